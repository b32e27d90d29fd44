#include <treelet/layout/double_bvh8.h>

#include <utility>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 12;

void set_lane(DoubleBlock& block, std::uint32_t lane, const DoubleTriangle& triangle) {
  const DoubleVec3 corners[3] = {triangle.p0, triangle.p1, triangle.p2};
  for (int corner = 0; corner < 3; ++corner) {
    for (int axis = 0; axis < 3; ++axis) block.vertex[corner][axis][lane] = corners[corner][axis];
  }
}

/// Lanes without a triangle repeat the first, as they do in floats.
DoubleBlock make_block(const TriangleBlock& boxes, const DoubleMesh& mesh) {
  DoubleBlock block;
  for (std::uint32_t lane = 0; lane < DoubleBlock::kTriangles; ++lane) {
    block.face[lane] = boxes.face[lane];
    const bool is_used = boxes.face[lane] != TriangleBlock::kNoFace;
    set_lane(block, lane, mesh.triangle(boxes.face[is_used ? lane : 0]));
  }
  return block;
}

}  // namespace

DoubleBvh8 pack_double_bvh8(Bvh8&& boxes, const DoubleMesh& mesh, const BoxFrame& frame) {
  const Stage stage{"write doubles"};
  DoubleBvh8 bvh;
  bvh.blocks = Array<DoubleBlock>(boxes.blocks.size());
  parallel_for(bvh.blocks.size(), kGrain,
               [&](std::size_t i) { bvh.blocks[i] = make_block(boxes.blocks[i], mesh); });
  bvh.nodes = std::move(boxes.nodes);
  bvh.frame = frame;
  bvh.bounds = boxes.bounds;
  bvh.depth = boxes.depth;
  return bvh;
}

}  // namespace treelet
