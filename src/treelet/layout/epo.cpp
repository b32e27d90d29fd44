#include <treelet/layout/epo.h>

#include <algorithm>
#include <span>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/layout/clip.h>
#include <treelet/primitive/radix_sort.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 256;

struct Areas {
  double overlap = 0.0;  // weighted by node cost
  double surface = 0.0;
};

/// Run of triangles below each node, which is one run because the order is depth first.
struct TriangleRun {
  std::uint32_t begin, end;
};

Array<TriangleRun> find_runs(const Bvh2& bvh) {
  Array<TriangleRun> runs(bvh.nodes.size());
  for (std::size_t i = bvh.nodes.size(); i-- > 0;) {
    const Bvh2Node& node = bvh.nodes[i];
    runs[i].begin = node.is_leaf(0) ? node.index[0] : runs[node.index[0]].begin;
    runs[i].end = node.is_leaf(1) ? node.index[1] + node.count[1] : runs[node.index[1]].end;
  }
  return runs;
}

/// Positions in leaf order by face: a split face has several.
Array<SortEntry> sort_by_face(const Bvh2& bvh) {
  Array<SortEntry> entries(bvh.triangles.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    entries[i] = {bvh.triangles[i].face, std::uint32_t(i)};
  }
  radix_sort(entries);
  return entries;
}

std::vector<std::size_t> find_face_starts(const Array<SortEntry>& by_face) {
  std::vector<std::size_t> starts;
  for (std::size_t i = 0; i < by_face.size(); ++i) {
    if (i == 0 || by_face[i].key != by_face[i - 1].key) starts.push_back(i);
  }
  starts.push_back(by_face.size());
  return starts;
}

class EndPointOverlap {
 public:
  EndPointOverlap(const Bvh2& bvh, const SahModel& sah)
      : bvh_(bvh),
        sah_(sah),
        runs_(find_runs(bvh)),
        by_face_(sort_by_face(bvh)),
        face_starts_(find_face_starts(by_face_)) {}

  double compute(std::size_t max_triangles) const {
    const std::size_t faces = face_starts_.size() - 1;
    const std::size_t samples = max_triangles == 0 ? faces : std::min(faces, max_triangles);
    const Areas areas = parallel_reduce(
        samples, kGrain, Areas{},
        [&](std::size_t begin, std::size_t end) {
          Areas range;
          for (std::size_t i = begin; i < end; ++i) add_face(i * faces / samples, range);
          return range;
        },
        [](Areas a, Areas b) { return Areas{a.overlap + b.overlap, a.surface + b.surface}; });
    return areas.surface > 0.0 ? areas.overlap / areas.surface : 0.0;
  }

 private:
  using Positions = std::span<const SortEntry>;

  struct Visit {
    std::uint32_t node;
    ClippedTriangle polygon;
  };

  void add_face(std::size_t rank, Areas& areas) const {
    const Positions positions(by_face_.begin() + face_starts_[rank],
                              by_face_.begin() + face_starts_[rank + 1]);
    const ClippedTriangle whole(bvh_.triangles[positions.front().value].triangle());
    areas.surface += whole.area();
    std::vector<Visit> stack{{0, whole}};
    while (!stack.empty()) {
      const Visit visit = stack.back();
      stack.pop_back();
      for (const int child : {0, 1}) add_child(visit, child, positions, stack, areas);
    }
  }

  void add_child(const Visit& visit, int child, Positions positions, std::vector<Visit>& stack,
                 Areas& areas) const {
    const Bvh2Node& node = bvh_.nodes[visit.node];
    ClippedTriangle polygon = visit.polygon;
    if (!in_subtree(node, child, positions)) {
      polygon.clip(node.box[child]);
      if (polygon.size == 0) return;
      const double cost = node.is_leaf(child) ? double(sah_.intersection_cost) * node.count[child]
                                              : double(sah_.traversal_cost);
      areas.overlap += cost * polygon.area();
    }
    if (!node.is_leaf(child)) stack.push_back({node.index[child], polygon});
  }

  bool in_subtree(const Bvh2Node& node, int child, Positions positions) const {
    TriangleRun run{node.index[child], node.index[child] + node.count[child]};
    if (!node.is_leaf(child)) run = runs_[node.index[child]];
    const auto found =
        std::lower_bound(positions.begin(), positions.end(), run.begin,
                         [](const SortEntry& p, std::uint32_t begin) { return p.value < begin; });
    return found != positions.end() && found->value < run.end;
  }

  const Bvh2& bvh_;
  const SahModel& sah_;
  const Array<TriangleRun> runs_;
  const Array<SortEntry> by_face_;
  const std::vector<std::size_t> face_starts_;
};

}  // namespace

double compute_epo(const Bvh2& bvh, const SahModel& sah, std::size_t max_triangles) {
  if (bvh.nodes.empty() || bvh.is_single_leaf()) return 0.0;
  return EndPointOverlap(bvh, sah).compute(max_triangles);
}

}  // namespace treelet
