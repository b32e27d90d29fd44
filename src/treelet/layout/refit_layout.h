#pragma once

#include <cstddef>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// What a refit found.
struct RefitResult {
  double sah = 0.0;        ///< cost of the layout now; at its build it was TreeStatistics::sah
  std::size_t hidden = 0;  ///< triangles in leaves that no ray can hit as they are now
};

/// Moves a layout's triangles to where the mesh has their faces now and makes its boxes fit again:
/// the same bytes as packing the same tree over the moved mesh. The mesh has the faces of the
/// build, with indices that have been checked. Leaves of split triangles get the boxes of the whole
/// ones.
///
/// A triangle that is not regular any more is hidden: it lies, without area, along the diagonal of
/// its leaf's box, where no ray hits it and no box grows for it. A leaf of nothing else shrinks to
/// a point, its first finite vertex or else the lower corner of its last box. What becomes regular
/// again appears again; faces that the build left out stay out.
RefitResult refit(Bvh2& bvh, const Mesh& mesh, const SahModel& sah);
RefitResult refit(Bvh8& bvh, const Mesh& mesh, const SahModel& sah);
/// Children keep their slots. Takes 25 bytes a node of scratch: grids need the exact boxes.
RefitResult refit(Cwbvh& bvh, const Mesh& mesh, const SahModel& sah);

}  // namespace treelet
