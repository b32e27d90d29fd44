#include <treelet/file/facts.h>

#include <cmath>

namespace treelet {
namespace {

// Each list of members is written once, for both ways: `visit` puts a value or takes it.

template <class Visit>
void visit_numbers(auto& bvh, Visit&& visit) {
  visit(bvh.sah.traversal_cost);
  visit(bvh.sah.intersection_cost);
  visit(bvh.sah.leaf_limit);
  for (auto& coordinate : bvh.placement.offset) visit(coordinate);
  visit(bvh.placement.rounding);
}

template <class Visit>
void visit_report(auto& report, Visit&& visit) {
  visit(report.seconds);
  visit(report.faces);
  visit(report.references);
  visit(report.left_out_non_finite);
  visit(report.left_out_degenerate);
  visit(report.sah);
  visit(report.tree.leaves);
  visit(report.tree.triangles);
  visit(report.tree.sah);
  visit(report.update.refits);
  visit(report.update.seconds);
  visit(report.update.sah);
  visit(report.update.hidden);
}

template <class Visit>
void visit_layout(auto& layout, Visit&& visit) {
  visit(layout.bounds);
  visit(layout.depth);
  if constexpr (requires { layout.triangle_count; }) visit(layout.triangle_count);
}

/// Counts take eight bytes on every machine.
struct Put {
  ByteWriter& writer;
  template <class T>
  void operator()(const T& value) const {
    if constexpr (std::is_same_v<T, std::size_t>) {
      writer.put(std::uint64_t(value));
    } else {
      writer.put(value);
    }
  }
};
struct Take {
  ByteReader& reader;
  template <class T>
  void operator()(T& value) const {
    if constexpr (std::is_same_v<T, std::size_t>) {
      value = std::size_t(reader.take<std::uint64_t>());
    } else {
      reader.take(value);
    }
  }
};

void require_plausible(const Bvh& bvh) {
  for (const double coordinate : bvh.placement.offset) {
    if (!std::isfinite(coordinate)) throw FileError("the offset is not finite");
  }
  if (bvh.report.faces > kMaxFaces) throw FileError("there are more faces than a mesh can have");
}

}  // namespace

void put_facts(const Bvh& bvh, ByteWriter& writer) {
  const Put put{writer};
  std::visit([&](const auto& layout) { visit_layout(layout, put); }, bvh.layout);
  visit_numbers(bvh, put);
  visit_report(bvh.report, put);
  writer.put_text(bvh.report.recipe);
  put(bvh.report.stages.size());
  for (const StageTime& stage : bvh.report.stages) {
    writer.put_text(stage.name);
    put(stage.seconds);
  }
  put(bvh.report.tree.leaf_histogram.size());
  for (const std::size_t leaves : bvh.report.tree.leaf_histogram) put(leaves);
}

void take_facts(ByteReader& reader, Bvh& bvh) {
  const Take take{reader};
  std::visit([&](auto& layout) { visit_layout(layout, take); }, bvh.layout);
  visit_numbers(bvh, take);
  visit_report(bvh.report, take);
  bvh.report.recipe = reader.take_text();
  bvh.report.stages.resize(reader.take_count(sizeof(std::uint32_t) + sizeof(double)));
  for (StageTime& stage : bvh.report.stages) {
    stage.name = reader.take_text();
    take(stage.seconds);
  }
  bvh.report.tree.leaf_histogram.resize(reader.take_count(sizeof(std::uint64_t)));
  for (std::size_t& leaves : bvh.report.tree.leaf_histogram) take(leaves);
  if (!reader.is_at_end()) throw FileError("more facts than this version has");
  require_plausible(bvh);
}

}  // namespace treelet
