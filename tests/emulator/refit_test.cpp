#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "launching.h"
#include "support/random.h"

namespace treelet::emulator::test {
namespace {

using treelet::test::Random;

/// A random binary tree: nodes [0, leaves - 1) have children, the others are leaves.
struct Tree {
  std::vector<int> parent;
  std::vector<int2> children;
};

/// Splits [first, last) at random; leaf i is node leaves - 1 + i.
int split(Tree& tree, int first, int last, int leaves, Random& random, int& next) {
  if (last - first == 1) return leaves - 1 + first;
  const int node = next++;
  const int middle = first + 1 + int(random.below(std::uint64_t(last - first - 1)));
  const int left = split(tree, first, middle, leaves, random, next);
  const int right = split(tree, middle, last, leaves, random, next);
  tree.children[std::size_t(node)] = make_int2(left, right);
  tree.parent[std::size_t(left)] = tree.parent[std::size_t(right)] = node;
  return node;
}

Tree make_tree(int leaves, std::uint64_t seed) {
  Tree tree{std::vector<int>(std::size_t(2 * leaves - 1), -1),
            std::vector<int2>(std::size_t(leaves - 1))};
  Random random(seed);
  int next = 0;
  split(tree, 0, leaves, leaves, random, next);
  return tree;
}

/// Bottom up: the second of two siblings to arrive goes on with their parent [Karras2012 s4].
__global__ void refit(const int* parent, const int2* children, float2* boxes, unsigned* visits,
                      int leaves) {
  const int i = int(blockIdx.x * blockDim.x + threadIdx.x);
  if (i >= leaves) return;
  for (int node = parent[leaves - 1 + i]; node >= 0; node = parent[node]) {
    __threadfence();
    if (atomicAdd(&visits[node], 1u) == 0) return;
    __threadfence();
    const float2 a = boxes[children[node].x], b = boxes[children[node].y];
    boxes[node] = make_float2(fminf(a.x, b.x), fmaxf(a.y, b.y));
  }
}

class Refit : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  SettingsScope scope_{with_seed(GetParam())};
};
INSTANTIATE_TEST_SUITE_P(Seeds, Refit, ::testing::ValuesIn(kSeeds));

TEST_P(Refit, BoundsTheLeavesBelow) {
  constexpr int kLeaves = 3000;
  const Tree tree = make_tree(kLeaves, GetParam());
  Random random(GetParam() + 99);
  std::vector<float2> boxes(2 * kLeaves - 1);
  for (int i = 0; i < kLeaves; ++i) {
    const float x = random.uniform(-1.0f, 1.0f);
    boxes[std::size_t(kLeaves - 1 + i)] = make_float2(x, x + 0.01f);
  }
  Buffer<int> parent(tree.parent);
  Buffer<int2> children(tree.children);
  Buffer<float2> device_boxes(boxes);
  Buffer<unsigned> visits(std::vector<unsigned>(kLeaves - 1, 0));
  ASSERT_EQ(run(refit, (kLeaves + 127) / 128, 128, parent.data(), children.data(),
                device_boxes.data(), visits.data(), kLeaves),
            cudaSuccess);

  // Children come after their parents.
  for (std::size_t node = kLeaves - 1; node-- > 0;) {
    const float2 a = boxes[std::size_t(tree.children[node].x)];
    const float2 b = boxes[std::size_t(tree.children[node].y)];
    boxes[node] = make_float2(std::min(a.x, b.x), std::max(a.y, b.y));
  }
  const auto got = device_boxes.read();
  for (std::size_t node = 0; node < boxes.size(); ++node) {
    EXPECT_EQ(got[node].x, boxes[node].x) << node;
    EXPECT_EQ(got[node].y, boxes[node].y) << node;
  }
  EXPECT_EQ(visits.read(), std::vector<unsigned>(kLeaves - 1, 2));
}

}  // namespace
}  // namespace treelet::emulator::test
