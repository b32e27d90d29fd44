#include <treelet/layout/epo.h>

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/layout/child_view.h>
#include <treelet/layout/clip.h>
#include <treelet/primitive/radix_sort.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 256;

struct Areas {
  double overlap = 0.0;  // weighted by node cost
  double surface = 0.0;
};

/// Positions below each node, which are one run because the order is depth first.
struct Run {
  std::size_t begin = std::numeric_limits<std::size_t>::max(), end = 0;
};

template <class Layout>
std::vector<Run> find_runs(const Layout& bvh) {
  std::vector<Run> runs(bvh.nodes.size());
  for (std::uint32_t node = std::uint32_t(bvh.nodes.size()); node-- > 0;) {
    for (int i = 0; i < children_per_node(bvh); ++i) {
      const ChildView child = child_of(bvh, node, i);
      if (child.box.is_empty()) continue;
      const Run run = child.is_leaf ? Run{child.begin, child.end} : runs[child.node];
      runs[node] = {std::min(runs[node].begin, run.begin), std::max(runs[node].end, run.end)};
    }
  }
  return runs;
}

/// Positions by face: a split face has several.
template <class Layout>
Array<SortEntry> sort_by_face(const Layout& bvh) {
  std::vector<SortEntry> found;
  for (std::size_t i = 0; i < position_count(bvh); ++i) {
    if (has_triangle(bvh, i)) found.push_back({face_at(bvh, i), std::uint32_t(i)});
  }
  Array<SortEntry> entries(found.size());
  std::copy(found.begin(), found.end(), entries.begin());
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

template <class Layout>
class EndPointOverlap {
 public:
  EndPointOverlap(const Layout& bvh, const SahModel& sah)
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
    const ClippedTriangle whole(triangle_at(bvh_, positions.front().value));
    areas.surface += whole.area();
    std::vector<Visit> stack{{0, whole}};
    while (!stack.empty()) {
      const Visit visit = stack.back();
      stack.pop_back();
      for (int i = 0; i < children_per_node(bvh_); ++i) {
        const ChildView child = child_of(bvh_, visit.node, i);
        if (!child.box.is_empty()) add_child(child, visit.polygon, positions, stack, areas);
      }
    }
  }

  void add_child(const ChildView& child, ClippedTriangle polygon, Positions positions,
                 std::vector<Visit>& stack, Areas& areas) const {
    if (!in_subtree(child, positions)) {
      polygon.clip(child.box);
      if (polygon.size == 0) return;
      areas.overlap += own_weight(bvh_, child, sah_) * polygon.area();
    }
    if (!child.is_leaf) stack.push_back({child.node, polygon});
  }

  bool in_subtree(const ChildView& child, Positions positions) const {
    const Run run = child.is_leaf ? Run{child.begin, child.end} : runs_[child.node];
    const auto found =
        std::lower_bound(positions.begin(), positions.end(), run.begin,
                         [](const SortEntry& p, std::size_t begin) { return p.value < begin; });
    return found != positions.end() && found->value < run.end;
  }

  const Layout& bvh_;
  const SahModel& sah_;
  const std::vector<Run> runs_;
  const Array<SortEntry> by_face_;
  const std::vector<std::size_t> face_starts_;
};

template <class Layout>
double compute(const Layout& bvh, const SahModel& sah, std::size_t max_triangles) {
  if (bvh.nodes.empty()) return 0.0;
  return EndPointOverlap<Layout>(bvh, sah).compute(max_triangles);
}

}  // namespace

double compute_epo(const Bvh2& bvh, const SahModel& sah, std::size_t max_triangles) {
  return compute(bvh, sah, max_triangles);
}
double compute_epo(const Bvh8& bvh, const SahModel& sah, std::size_t max_triangles) {
  return compute(bvh, sah, max_triangles);
}

}  // namespace treelet
