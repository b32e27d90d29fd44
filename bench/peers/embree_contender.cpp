#include "peers/embree_contender.h"

#include "peers/embree_device.h"
#include "peers/embree_rays.h"

namespace treelet::peers {
namespace {

class EmbreeContender final : public Contender {
 public:
  explicit EmbreeContender(const EmbreeOptions& options) : options_(options) {}
  ~EmbreeContender() override { drop(); }
  EmbreeContender(const EmbreeContender&) = delete;
  EmbreeContender& operator=(const EmbreeContender&) = delete;

  std::string label() const override { return options_.label(); }
  std::string recipe() const override { return options_.text(); }

  void build(const Mesh& mesh) override;
  void drop() override;
  JsonObject describe_tree() const override;

  bool can_answer(Query) const override { return true; }
  void answer(Query query, const RayBatch& rays, Answers& answers) const override;
  JsonObject count_work(const RayBatch&) const override { return {}; }

 private:
  void attach(const Mesh& mesh);

  EmbreeOptions options_;
  EmbreeDevice device_;  // one each, so that each contender's memory is counted by itself
  RTCScene scene_ = nullptr;
};

void EmbreeContender::build(const Mesh& mesh) {
  drop();
  scene_ = rtcNewScene(device_.get());
  rtcSetSceneBuildQuality(scene_, options_.quality);
  rtcSetSceneFlags(scene_, options_.flags());
  attach(mesh);
  rtcCommitScene(scene_);
  device_.check();
}

void EmbreeContender::attach(const Mesh& mesh) {
  const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetGeometryBuildQuality(geometry, options_.quality);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             mesh.vertices.data(), 0, sizeof(Vec3), mesh.vertices.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             mesh.faces.data(), 0, sizeof(Face), mesh.faces.size());
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_, geometry);
  rtcReleaseGeometry(geometry);  // the scene keeps it
}

void EmbreeContender::drop() {
  if (scene_ != nullptr) rtcReleaseScene(scene_);
  scene_ = nullptr;
}

JsonObject EmbreeContender::describe_tree() const {
  JsonObject facts;
  facts.add("bytes", double(device_.held_bytes()));
  facts.add("embree", device_.version());
  return facts;
}

void EmbreeContender::answer(Query query, const RayBatch& rays, Answers& answers) const {
  switch (query) {
    case Query::closest:
      return find_closest(scene_, rays, answers.hits());
    case Query::packets:
      return find_closest_in_packets(scene_, rays, answers.hits());
    case Query::any:
      return find_occluded(scene_, rays, answers.any_hits());
  }
}

}  // namespace

std::unique_ptr<Contender> make_embree_contender(std::string_view text) {
  return std::make_unique<EmbreeContender>(parse_embree_options(text));
}

}  // namespace treelet::peers
