#include <treelet/primitive/split.h>

#include <algorithm>
#include <utility>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/split_steps.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 12;

class Splitter {
 public:
  Splitter(const References& references, const Mesh& mesh)
      : references_(references),
        mesh_(mesh),
        grid_(make_morton_grid(references.bounds)),
        scale_(power_of_two(-references.scale_exponent)),
        priorities_(references.size()) {}

  Array<Reference> split(std::size_t budget) {
    const float largest = compute_priorities();
    return write_pieces(find_factor(largest, budget));
  }

 private:
  ExactTriangle triangle(std::size_t i) const {
    return {mesh_.triangle(references_.items[i].face), scale_};
  }

  /// Returns the largest.
  float compute_priorities() {
    return parallel_reduce(
        references_.size(), kGrain, 0.0f,
        [&](std::size_t begin, std::size_t end) {
          float largest = 0.0f;
          for (std::size_t i = begin; i < end; ++i) {
            priorities_[i] = split_priority(grid_, triangle(i), references_.items[i].box());
            largest = max(largest, priorities_[i]);
          }
          return largest;
        },
        [](float a, float b) { return max(a, b); });
  }

  std::size_t count_range(float factor, std::size_t begin, std::size_t end) const {
    std::size_t splits = 0;
    for (std::size_t i = begin; i < end; ++i) splits += split_count(factor, priorities_[i]);
    return splits;
  }

  std::size_t count_all(float factor) const {
    return parallel_reduce(
        priorities_.size(), kGrain, std::size_t{0},
        [&](std::size_t begin, std::size_t end) { return count_range(factor, begin, end); },
        [](std::size_t a, std::size_t b) { return a + b; });
  }

  float find_factor(float largest, std::size_t budget) const {
    FactorSearch search(largest, budget);
    for (int i = 0; i < FactorSearch::kRounds; ++i) search.learn(count_all(search.candidate()));
    return search.factor();
  }

  Array<Reference> write_pieces(float factor) const {
    const std::size_t count = references_.size();
    std::vector<std::size_t> offsets((count + kGrain - 1) / kGrain);
    parallel_for_ranges(count, kGrain, [&](std::size_t begin, std::size_t end) {
      offsets[begin / kGrain] = end - begin + count_range(factor, begin, end);
    });
    std::size_t total = 0;
    for (std::size_t& offset : offsets) total += std::exchange(offset, total);
    Array<Reference> pieces(total);
    parallel_for_ranges(count, kGrain, [&](std::size_t begin, std::size_t end) {
      Reference* out = pieces.data() + offsets[begin / kGrain];
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t splits = split_count(factor, priorities_[i]);
        split_triangle(grid_, triangle(i), references_.items[i].face, splits, out);
        out += splits + 1;
      }
    });
    return pieces;
  }

  const References& references_;
  const Mesh& mesh_;
  const MortonGrid grid_;
  const double scale_;
  Array<float> priorities_;
};

}  // namespace

void split_references(References& references, const Mesh& mesh, std::size_t budget) {
  const Stage stage{"split triangles"};
  const std::size_t before = references.size();
  references.items = Splitter(references, mesh).split(std::min(budget, kMaxFaces - before));
  references.may_repeat_faces = references.size() > before;
}

}  // namespace treelet
