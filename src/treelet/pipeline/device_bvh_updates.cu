#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include <treelet/core/cuda_error.h>
#include <treelet/core/device_array.h>
#include <treelet/core/device_scope.h>
#include <treelet/layout/device_refit_layout.h>
#include <treelet/pipeline/device_bvh_impl.h>

// Updates of a DeviceBvh: refit, rebuild, and what checks a rebuild.

namespace treelet::cuda {

UpdateMemory& DeviceBvh::Impl::updatable(std::uint32_t vertices) {
  if (!update) {
    throw std::logic_error("the tree cannot be updated: build it with updatable=True");
  }
  if (vertices == update->vertex_count) return *update;
  throw std::invalid_argument("the tree was built over " + std::to_string(update->vertex_count) +
                              " vertices and cannot be updated with " + std::to_string(vertices) +
                              ": an update moves vertices, it neither adds nor removes any");
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

}  // namespace treelet::cuda
