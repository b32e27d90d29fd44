#include <treelet/pipeline/device_bvh.h>

#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <treelet/layout/device_epo.h>
#include <treelet/layout/device_statistics.h>
#include <treelet/pipeline/device_bvh_impl.h>
#include <treelet/tree/validate.h>
#include <treelet/tree/violations.h>
#include <treelet/core/cuda_check.cuh>

namespace treelet::cuda {
namespace {

/// Blocks are numbered by 29 bits.
void require_numbers(const Recipe& recipe, const LayoutSize& size) {
  if (recipe.layout.word->name != "bvh8" || size.items <= DeviceBvh8::kMaxItems) return;
  throw std::invalid_argument(
      "the mesh needs " + std::to_string(size.items) + " blocks of triangles; bvh8 holds " +
      std::to_string(DeviceBvh8::kMaxItems) + ": use bvh2, larger leaves, or split the mesh");
}

/// More references than faces that have any.
bool has_split_faces(const BuildReport& report) {
  const std::size_t left_out = report.left_out_non_finite + report.left_out_degenerate;
  return report.references + left_out != report.faces;
}

}  // namespace

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

/// On a stream that is there for certain.
DeviceBvh::Impl::~Impl() {
  const Stream own = own_stream();
  writes.order_behind(own);
  reads.order_behind(own);
  free_on(storage, own);
  if (update) update->free_on(own);
  for (auto& [old_storage, old_links] : retired) {
    free_on(old_storage, own);
    old_links.free_on(own);
  }
}

const BuildReport& DeviceBvh::Impl::finished_report() const {
  const DeviceScope scope(device);
  const std::lock_guard lock(report_mutex);
  if (stages) {
    report.stages = stages->finish();
    for (const StageTime& stage : report.stages) report.seconds += stage.seconds;
    stages.reset();
  }
  if (!has_statistics) measure_layout();
  return report;
}

/// Statistics of the layout as it is now: those of the build, until it is refitted.
void DeviceBvh::Impl::measure_layout() const {
  const Stream stream = reading_stream();
  TreeStatistics statistics;
  visit([&](const auto& bvh) { statistics = compute_statistics(bvh, sah, stream); });
  report.update.sah = statistics.sah;
  report.update.hidden = read_summary(stream).hidden;
  if (report.update.refits == 0) report.tree = std::move(statistics);
  has_statistics = true;
}

void DeviceBvh::Impl::set_outcome(const Outcome& outcome) {
  report.references = outcome.scene.reference_count;
  report.left_out_non_finite = outcome.scene.left_out_non_finite;
  report.left_out_degenerate = outcome.scene.left_out_degenerate;
  report.sah = outcome.sah;
  depth = outcome.size.depth;
  has_statistics = false;
}

DeviceBvh::DeviceBvh(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DeviceBvh::DeviceBvh(DeviceBvh&&) noexcept = default;
DeviceBvh& DeviceBvh::operator=(DeviceBvh&& other) noexcept {
  std::swap(impl_, other.impl_);
  return *this;
}
DeviceBvh::~DeviceBvh() {
  if (!impl_) return;
  const DeviceScope scope(impl_->device);
  impl_.reset();
}

DeviceBvh DeviceBvh::build(const DeviceMesh& mesh, const Recipe& recipe,
                           const DeviceBuildOptions& options, Stream stream) {
  require_device_words(recipe);
  check_face_count(mesh.face_count);
  auto impl = std::make_unique<Impl>();
  impl->report.recipe = recipe.text();
  impl->report.faces = mesh.face_count;
  impl->repeats_faces = recipe.splitter.has_value();
  Workspace workspace(mesh.face_count, recipe, stream);
  const BuildMemory& memory = workspace.memory();

  DevicePipeline pipeline(mesh, recipe, memory, stream, &impl->stages.emplace(stream));
  impl->sah = pipeline.sah();
  pipeline.build_tree([&](std::string_view stage) {
    if (!options.validate) return;
    require_sound(stage, validate(memory.tree, pipeline.references(), stream));
  });
  pipeline.plan_layout();
  impl->stages->begin("wait and allocate");
  const Outcome outcome = read_outcome(memory, stream);
  require_valid_indices(mesh, outcome.scene, stream);
  require_numbers(recipe, outcome.size);
  const auto room = [&](std::uint32_t size) { return options.updatable ? with_slack(size) : size; };
  impl->storage = allocate(recipe, room(outcome.size.nodes), room(outcome.size.items), stream);
  impl->visit([&](const auto& bvh) { pipeline.write_layout(bvh); });
  impl->stages->end();
  impl->set_outcome(outcome);
  if (options.updatable) {
    DeviceArray<Face> faces(mesh.face_count, stream);
    copy_on_device(faces.data(), mesh.faces, faces.bytes(), stream);
    impl->update.emplace(UpdateMemory{recipe, std::move(faces), mesh.vertex_count,
                                      std::move(workspace),
                                      LinkMemory(impl->storage, room(outcome.size.nodes), stream)});
  }
  impl->writes.record(stream);
  if (options.updatable) {
    impl->report.update.held_bytes = impl->held_bytes();
    impl->finished_report();  // what refits are measured against
  }
  return DeviceBvh(std::move(impl));
}

DeviceBvh DeviceBvh::upload(const Bvh& bvh, Stream stream) {
  auto impl = std::make_unique<Impl>();
  impl->sah = bvh.sah;
  impl->report = bvh.report;
  impl->report.update = {};
  impl->has_statistics = true;
  impl->depth = bvh.report.tree.depth;
  impl->repeats_faces = has_split_faces(bvh.report);
  impl->storage =
      std::visit([&](const auto& layout) { return upload_any(layout, stream); }, bvh.layout);
  return DeviceBvh(std::move(impl));
}

Bvh DeviceBvh::download(Stream stream) const {
  Bvh bvh;
  impl_->read(stream,
              [&](const auto& layout) { bvh.layout = treelet::cuda::download(layout, stream); });
  bvh.sah = impl_->sah;
  bvh.report = report();
  return bvh;
}

const BuildReport& DeviceBvh::report() const { return impl_->finished_report(); }
int DeviceBvh::device() const { return impl_->device; }

Aabb DeviceBvh::bounds() const {
  const DeviceScope scope(impl_->device);
  return impl_->read_summary(impl_->reading_stream()).bounds;
}

double DeviceBvh::epo(std::size_t max_triangles) const {
  const DeviceScope scope(impl_->device);
  const Stream stream = impl_->reading_stream();
  double epo = 0.0;
  impl_->visit([&](const auto& bvh) {
    epo = compute_epo(bvh, impl_->sah, std::uint32_t(impl_->report.faces), stream, max_triangles);
  });
  return epo;
}

}  // namespace treelet::cuda
