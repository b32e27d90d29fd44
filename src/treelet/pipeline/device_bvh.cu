#include <treelet/pipeline/device_bvh.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <treelet/core/cuda_error.h>
#include <treelet/core/device_array.h>
#include <treelet/core/device_scope.h>
#include <treelet/layout/device_refit_layout.h>
#include <treelet/layout/device_statistics.h>
#include <treelet/pipeline/device_build.h>
#include <treelet/query/device_intersect.h>
#include <treelet/tree/validate.h>
#include <treelet/core/cuda_check.cuh>

namespace treelet::cuda {
namespace {

using Storage = std::variant<Bvh2Storage, Bvh8Storage>;

/// What the host reads of a build, once.
struct Outcome {
  DeviceScene scene;
  LayoutSize size;
  double sah;
};

Outcome read_outcome(const BuildMemory& memory, Stream stream) {
  Outcome outcome;
  check(cudaMemcpyAsync(&outcome.scene, memory.scene, sizeof(outcome.scene), cudaMemcpyDeviceToHost,
                        stream),
        "copy from the device");
  check(cudaMemcpyAsync(&outcome.size, memory.planned_size(), sizeof(outcome.size),
                        cudaMemcpyDeviceToHost, stream),
        "copy from the device");
  copy_to_host(&outcome.sah, memory.sah, sizeof(outcome.sah), stream);
  return outcome;
}

void require_sound(std::string_view stage, const std::vector<std::string>& violations) {
  if (violations.empty()) return;
  std::string message = "after '" + std::string(stage) + "' the tree is broken:";
  for (const std::string& violation : violations) message += "\n  " + violation;
  throw std::logic_error(message);
}

/// Memory of a build that carves itself.
class Workspace {
 public:
  Workspace(std::uint32_t faces, const Recipe& recipe, Stream stream) {
    Carver counting;
    carve_build(counting, faces, recipe);
    block_ = DeviceArray<std::byte>(counting.peak(), stream);
    Carver carver(block_.data());
    memory_ = carve_build(carver, faces, recipe);
  }

  const BuildMemory& memory() const { return memory_; }

 private:
  DeviceArray<std::byte> block_;
  BuildMemory memory_;
};

/// What a tree keeps to be updated.
struct UpdateMemory {
  Recipe recipe;
  DeviceArray<Face> faces;
  std::uint32_t vertex_count;
  Workspace workspace;
  DeviceArray<NodeLink> links;

  DeviceMesh mesh(const Vec3* vertices) const {
    return {vertices, faces.data(), vertex_count, std::uint32_t(faces.size())};
  }
};

Storage allocate(const Recipe& recipe, std::uint32_t nodes, std::uint32_t items, Stream stream) {
  if (recipe.layout.word->name == "bvh2") return Bvh2Storage(nodes, items, stream);
  return Bvh8Storage(nodes, items, stream);
}

const Array<PackedTriangle>& items_of(const Bvh2& bvh) { return bvh.triangles; }
const Array<TriangleBlock>& items_of(const Bvh8& bvh) { return bvh.blocks; }
std::size_t triangle_count(const Bvh2& bvh) { return bvh.triangles.size(); }
std::size_t triangle_count(const Bvh8& bvh) { return bvh.triangle_count; }

template <class Stored, class Layout>
Storage upload_layout(const Layout& bvh, Stream stream) {
  const auto& items = items_of(bvh);
  const std::uint32_t nodes = std::uint32_t(bvh.nodes.size());
  const LayoutSummary summary{
      bvh.bounds,
      {nodes, std::uint32_t(items.size()), std::uint32_t(triangle_count(bvh)), bvh.depth},
      0,
      0};
  Stored stored(nodes, std::uint32_t(items.size()), stream);
  copy_to_device(stored.view().nodes, bvh.nodes.data(), bvh.nodes.bytes(), stream);
  copy_to_device(stored.view().items, items.data(), items.bytes(), stream);
  copy_to_device(stored.view().summary, &summary, sizeof(summary), stream);
  synchronize(stream);
  return stored;
}
Storage upload_any(const Bvh2& bvh, Stream stream) {
  return upload_layout<Bvh2Storage>(bvh, stream);
}
Storage upload_any(const Bvh8& bvh, Stream stream) {
  return upload_layout<Bvh8Storage>(bvh, stream);
}

/// Blocks are numbered by 29 bits.
void require_numbers(const Recipe& recipe, const LayoutSize& size) {
  if (recipe.layout.word->name != "bvh8" || size.items <= DeviceBvh8::kMaxItems) return;
  throw std::invalid_argument(
      "the mesh needs " + std::to_string(size.items) + " blocks of triangles; bvh8 holds " +
      std::to_string(DeviceBvh8::kMaxItems) + ": use bvh2, larger leaves, or split the mesh");
}

/// A rebuild may need more than the build it comes after.
constexpr std::uint32_t with_slack(std::uint32_t size) { return size + size / 4 + 16; }

}  // namespace

class DeviceBvh::Impl {
 public:
  mutable Storage storage;  // a view of it does not change the tree
  std::optional<UpdateMemory> update;
  SahModel sah;
  Stream stream = nullptr;
  int device = current_device();
  mutable std::optional<DeviceStages> stages;
  mutable BuildReport report;
  mutable bool has_statistics = false;

  template <class Visit>
  void visit(Visit&& visit_layout) const {
    std::visit([&](auto& stored) { visit_layout(stored.view()); }, storage);
  }

  LayoutSummary read_summary() const {
    LayoutSummary summary;
    visit([&](const auto& bvh) { copy_to_host(&summary, bvh.summary, sizeof(summary), stream); });
    return summary;
  }

  /// The report with what takes a wait to know.
  const BuildReport& finished_report() const {
    if (stages) {
      report.stages = stages->finish();
      for (const StageTime& stage : report.stages) report.seconds += stage.seconds;
      stages.reset();
    }
    if (!has_statistics) {
      visit([&](const auto& bvh) { report.tree = compute_statistics(bvh, sah, stream); });
      has_statistics = true;
    }
    return report;
  }

  void set_outcome(const Outcome& outcome) {
    report.references = outcome.scene.reference_count;
    report.left_out_non_finite = outcome.scene.left_out_non_finite;
    report.left_out_degenerate = outcome.scene.left_out_degenerate;
    report.sah = outcome.sah;
    report.tree.depth = outcome.size.depth;
    has_statistics = false;
  }

  UpdateMemory& updatable(std::uint32_t vertices) {
    if (!update) {
      throw std::logic_error("the tree cannot be updated: build it with updatable=True");
    }
    if (vertices == update->vertex_count) return *update;
    throw std::invalid_argument("the tree was built over " + std::to_string(update->vertex_count) +
                                " vertices and cannot be updated with " + std::to_string(vertices) +
                                ": an update moves vertices, it neither adds nor removes any");
  }
};

DeviceBvh::DeviceBvh(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DeviceBvh::DeviceBvh(DeviceBvh&&) noexcept = default;
DeviceBvh& DeviceBvh::operator=(DeviceBvh&&) noexcept = default;
DeviceBvh::~DeviceBvh() = default;

DeviceBvh DeviceBvh::build(const DeviceMesh& mesh, const Recipe& recipe,
                           const DeviceBuildOptions& options, Stream stream) {
  require_device_words(recipe);
  check_face_count(mesh.face_count);
  auto impl = std::make_unique<Impl>();
  impl->stream = stream;
  impl->report.recipe = recipe.text();
  impl->report.faces = mesh.face_count;
  Workspace workspace(mesh.face_count, recipe, stream);
  const BuildMemory& memory = workspace.memory();

  DevicePipeline pipeline(mesh, recipe, memory, stream, &impl->stages.emplace(stream));
  impl->sah = pipeline.sah();
  pipeline.build_tree([&](std::string_view stage) {
    if (!options.validate) return;
    require_sound(stage, validate(memory.tree, pipeline.references(), stream));
  });
  pipeline.plan_layout();
  const Outcome outcome = read_outcome(memory, stream);
  require_valid_indices(mesh, outcome.scene, stream);
  require_numbers(recipe, outcome.size);
  const auto room = [&](std::uint32_t size) { return options.updatable ? with_slack(size) : size; };
  impl->storage = allocate(recipe, room(outcome.size.nodes), room(outcome.size.items), stream);
  impl->visit([&](const auto& bvh) { pipeline.write_layout(bvh); });
  impl->set_outcome(outcome);
  if (options.updatable) {
    DeviceArray<Face> faces(mesh.face_count, stream);
    copy_on_device(faces.data(), mesh.faces, faces.bytes(), stream);
    impl->update.emplace(UpdateMemory{recipe, std::move(faces), mesh.vertex_count,
                                      std::move(workspace),
                                      DeviceArray<NodeLink>(room(outcome.size.nodes), stream)});
  }
  return DeviceBvh(std::move(impl));
}

DeviceBvh DeviceBvh::upload(const Bvh& bvh, Stream stream) {
  auto impl = std::make_unique<Impl>();
  impl->stream = stream;
  impl->sah = bvh.sah;
  impl->report = bvh.report;
  impl->has_statistics = true;
  impl->storage =
      std::visit([&](const auto& layout) { return upload_any(layout, stream); }, bvh.layout);
  return DeviceBvh(std::move(impl));
}

Bvh DeviceBvh::download(Stream stream) const {
  Bvh bvh;
  impl_->visit([&](const auto& layout) { bvh.layout = treelet::cuda::download(layout, stream); });
  bvh.sah = impl_->sah;
  bvh.report = report();
  return bvh;
}

const BuildReport& DeviceBvh::report() const { return impl_->finished_report(); }
int DeviceBvh::device() const { return impl_->device; }
Aabb DeviceBvh::bounds() const { return impl_->read_summary().bounds; }

void DeviceBvh::refit(const Vec3* vertices, std::uint32_t count, Stream stream) {
  UpdateMemory& update = impl_->updatable(count);
  impl_->stream = stream;
  impl_->visit([&](const auto& bvh) {
    treelet::cuda::refit(bvh, update.mesh(vertices), update.links.data(), stream);
  });
  ++impl_->report.update.refits;
}

void DeviceBvh::rebuild(const Vec3* vertices, std::uint32_t count, Stream stream) {
  const UpdateMemory& update = impl_->updatable(count);
  impl_->stream = stream;
  const DeviceMesh mesh = update.mesh(vertices);
  DevicePipeline pipeline(mesh, update.recipe, update.workspace.memory(), stream, nullptr);
  pipeline.build_tree([](std::string_view) {});
  pipeline.plan_layout();
  impl_->visit([&](const auto& bvh) { pipeline.write_layout(bvh); });
}

void DeviceBvh::check(Stream stream) {
  if (!impl_->update) return;
  const UpdateMemory& update = *impl_->update;
  const Outcome outcome = read_outcome(update.workspace.memory(), stream);
  impl_->set_outcome(outcome);
  if (impl_->read_summary().overflowed == 0) return;
  const std::uint32_t nodes = with_slack(outcome.size.nodes);
  impl_->storage = allocate(update.recipe, nodes, with_slack(outcome.size.items), stream);
  impl_->update->links = DeviceArray<NodeLink>(nodes, stream);
  throw CudaError(
      "the rebuilt tree did not fit the memory of the first one and is empty; there is "
      "room for it now: rebuild once more");
}

void DeviceBvh::intersect(const DeviceRayBatch& rays, const HitArrays& hits, Stream stream) const {
  impl_->visit([&](const auto& bvh) {
    treelet::cuda::intersect(bvh, impl_->report.tree.depth, rays, hits, stream);
  });
}

void DeviceBvh::find_occluded(const DeviceRayBatch& rays, bool* occluded, Stream stream) const {
  impl_->visit([&](const auto& bvh) {
    treelet::cuda::find_occluded(bvh, impl_->report.tree.depth, rays, occluded, stream);
  });
}

void DeviceBvh::count_work(const DeviceRayBatch& rays, const WorkArrays& work,
                           Stream stream) const {
  impl_->visit([&](const auto& bvh) {
    treelet::cuda::count_work(bvh, impl_->report.tree.depth, rays, work, stream);
  });
}

}  // namespace treelet::cuda
