#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include <treelet/core/device_array.h>
#include <treelet/core/device_scope.h>
#include <treelet/core/use_log.h>
#include <treelet/pipeline/device_build.h>
#include <treelet/pipeline/device_bvh.h>
#include <treelet/pipeline/device_storage.h>
#include <treelet/query/device_all_hits.h>

// What a DeviceBvh is made of, for the files that implement it.

namespace treelet::cuda {

/// What the host reads of a build, once.
struct Outcome {
  DeviceScene scene;
  LayoutSize size;
  double sah;
};

Outcome read_outcome(const BuildMemory& memory, Stream stream);

/// A rebuild may need more than the build it comes after.
constexpr std::uint32_t with_slack(std::uint32_t size) { return size + size / 4 + 16; }

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
  std::uint32_t depth = 0;     ///< of the layout, as far as the host knows
  bool repeats_faces = false;  ///< triangles may have been split

  TreeFacts facts() const { return {depth, repeats_faces}; }

  template <class Visit>
  void visit(Visit&& visit_layout) const {
    std::visit([&](auto& stored) { visit_layout(stored.view()); }, storage);
  }

  /// Memory is freed behind all that uses it.
  ~Impl();

  /// Calls query(layout) between what came before and what comes after on other streams.
  template <class Query>
  void read(Stream stream, Query&& query) const {
    const DeviceScope scope(device);
    writes.order_behind(stream);
    visit(query);
    reads.record(stream);
  }

  // Of the queries in query/device_queries.h; rays on the host are done on return.
  template <class Query>
  void trace(const DeviceRayBatch& rays, RayOrder order, const Query& query, Stream stream) const;
  template <class Query>
  void trace(const RayBatch& rays, const StreamOptions& options, const Query& query) const;

  /// Calls change(layout) behind all that came before.
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
  const BuildReport& finished_report() const;

  void set_outcome(const Outcome& outcome);

  std::size_t held_bytes() const {
    const std::size_t layout =
        std::visit([](const auto& stored) { return stored.bytes(); }, storage);
    return update ? layout + update->bytes() : 0;
  }

  /// What an update of so many vertices needs; throws where there can be none.
  UpdateMemory& updatable(std::uint32_t vertices);

 private:
  void measure_layout() const;
};

}  // namespace treelet::cuda
