#include <treelet/pipeline/device_bvh.h>

#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <treelet/core/cuda_error.h>
#include <treelet/core/device_array.h>
#include <treelet/core/device_scope.h>
#include <treelet/core/use_log.h>
#include <treelet/layout/device_epo.h>
#include <treelet/layout/device_refit_layout.h>
#include <treelet/layout/device_statistics.h>
#include <treelet/pipeline/device_build.h>
#include <treelet/pipeline/device_storage.h>
#include <treelet/query/device_intersect.h>
#include <treelet/query/device_queries.h>
#include <treelet/tree/validate.h>
#include <treelet/core/cuda_check.cuh>

namespace treelet::cuda {
namespace {

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
  int device = current_device();
  UseLog writes;
  mutable UseLog reads;
  std::vector<std::pair<Storage, LinkMemory>> retired;  // a recorded graph may write there
  mutable std::optional<DeviceStages> stages;
  mutable BuildReport report;
  mutable bool has_statistics = false;
  mutable std::mutex report_mutex;
  std::uint32_t depth = 0;  ///< of the layout, as far as the host knows

  template <class Visit>
  void visit(Visit&& visit_layout) const {
    std::visit([&](auto& stored) { visit_layout(stored.view()); }, storage);
  }

  /// Memory is freed behind all that uses it, on a stream that is there for certain.
  ~Impl() {
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

  /// Calls query(layout) between what came before and what comes after on other streams.
  template <class Query>
  void read(Stream stream, Query&& query) const {
    const DeviceScope scope(device);
    writes.order_behind(stream);
    visit(query);
    reads.record(stream);
  }

  template <class Query>
  void trace(const DeviceRayBatch& rays, RayOrder order, const Query& query, Stream stream) const {
    read(stream,
         [&](const auto& bvh) { trace_rays_in_order(bvh, depth, rays, order, query, stream); });
  }

  /// Queries rays on the host. All is done on return, so nothing need wait for it later.
  template <class Query>
  void trace(const RayBatch& rays, const StreamOptions& options, const Query& query) const {
    const DeviceScope scope(device);
    const auto trace_chunk = [&](const DeviceRayBatch& chunk, std::span<void* const> arrays,
                                 Stream stream) {
      writes.order_behind(stream);
      visit([&](const auto& bvh) {
        trace_rays_in_order(bvh, depth, chunk, options.order, Query::into(arrays), stream);
      });
    };
    stream_rays(rays, query.answers(), options, trace_chunk);
  }

  template <class Write>
  void write(Stream stream, Write&& change) {
    const DeviceScope scope(device);
    writes.order_behind(stream);
    reads.order_behind(stream);
    visit(change);
    writes.record(stream);
  }

  /// A stream for reading what the host asks for, behind all writes.
  Stream reading_stream() const {
    const Stream stream = own_stream();
    writes.order_behind(stream);
    return stream;
  }

  LayoutSummary read_summary(Stream stream) const {
    LayoutSummary summary;
    visit([&](const auto& bvh) { copy_to_host(&summary, bvh.summary, sizeof(summary), stream); });
    return summary;
  }

  /// The report with what takes a wait to know.
  const BuildReport& finished_report() const {
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
  void measure_layout() const {
    const Stream stream = reading_stream();
    TreeStatistics statistics;
    visit([&](const auto& bvh) { statistics = compute_statistics(bvh, sah, stream); });
    report.update.sah = statistics.sah;
    report.update.hidden = read_summary(stream).hidden;
    if (report.update.refits == 0) report.tree = std::move(statistics);
    has_statistics = true;
  }

  void set_outcome(const Outcome& outcome) {
    report.references = outcome.scene.reference_count;
    report.left_out_non_finite = outcome.scene.left_out_non_finite;
    report.left_out_degenerate = outcome.scene.left_out_degenerate;
    report.sah = outcome.sah;
    depth = outcome.size.depth;
    has_statistics = false;
  }

  std::size_t held_bytes() const {
    const std::size_t layout =
        std::visit([](const auto& stored) { return stored.bytes(); }, storage);
    return update ? layout + update->bytes() : 0;
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

void DeviceBvh::refit(const Vec3* vertices, std::uint32_t count, Stream stream) {
  UpdateMemory& update = impl_->updatable(count);
  impl_->write(stream, [&](const auto& bvh) {
    treelet::cuda::refit(bvh, update.mesh(vertices), update.links.of(bvh), stream);
  });
  ++impl_->report.update.refits;
  impl_->has_statistics = false;
}

void DeviceBvh::rebuild(const Vec3* vertices, std::uint32_t count, Stream stream) {
  const UpdateMemory& update = impl_->updatable(count);
  const DeviceMesh mesh = update.mesh(vertices);
  impl_->write(stream, [&](const auto& bvh) {
    DevicePipeline pipeline(mesh, update.recipe, update.workspace.memory(), stream, nullptr);
    pipeline.build_tree([](std::string_view) {});
    pipeline.plan_layout();
    pipeline.write_layout(bvh);
  });
  impl_->report.update.refits = 0;
  impl_->has_statistics = false;
}

void DeviceBvh::check(Stream stream) {
  if (!impl_->update) return;
  const DeviceScope scope(impl_->device);
  impl_->writes.order_behind(stream);
  UpdateMemory& update = *impl_->update;
  const Outcome outcome = read_outcome(update.workspace.memory(), stream);
  impl_->set_outcome(outcome);
  const LayoutSummary summary = impl_->read_summary(stream);
  if (summary.overflowed == 0) {
    impl_->finished_report();
    return;
  }
  const std::uint32_t nodes = with_slack(outcome.size.nodes);
  Storage larger = allocate(update.recipe, nodes, with_slack(outcome.size.items), stream);
  std::visit(
      [&](auto& stored) {
        copy_to_device(stored.view().summary, &summary, sizeof(summary), stream);
      },
      larger);
  LinkMemory links(larger, nodes, stream);
  synchronize(stream);
  std::swap(impl_->storage, larger);
  std::swap(update.links, links);
  impl_->retired.emplace_back(std::move(larger), std::move(links));
  impl_->report.update.held_bytes = impl_->held_bytes();
  throw CudaError(
      "the rebuilt tree did not fit the memory of the first one and is empty; there is room for it "
      "now: rebuild once more, and record graphs anew");
}

void DeviceBvh::intersect(const DeviceRayBatch& rays, const HitArrays& hits, Stream stream,
                          RayOrder order) const {
  impl_->trace(rays, order, ClosestHitQuery{hits}, stream);
}
void DeviceBvh::find_occluded(const DeviceRayBatch& rays, bool* occluded, Stream stream,
                              RayOrder order) const {
  impl_->trace(rays, order, AnyHitQuery{occluded}, stream);
}
void DeviceBvh::count_work(const DeviceRayBatch& rays, const WorkArrays& work, Stream stream,
                           RayOrder order) const {
  impl_->trace(rays, order, WorkQuery{work}, stream);
}

void DeviceBvh::intersect(const RayBatch& rays, const HitArrays& hits,
                          const StreamOptions& options) const {
  impl_->trace(rays, options, ClosestHitQuery{hits});
}
void DeviceBvh::find_occluded(const RayBatch& rays, bool* occluded,
                              const StreamOptions& options) const {
  impl_->trace(rays, options, AnyHitQuery{occluded});
}
void DeviceBvh::count_work(const RayBatch& rays, const WorkArrays& work,
                           const StreamOptions& options) const {
  impl_->trace(rays, options, WorkQuery{work});
}

}  // namespace treelet::cuda
