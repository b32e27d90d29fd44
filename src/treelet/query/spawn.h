#pragma once

#include <treelet/core/vec.h>
#include <treelet/mesh/mesh.h>

namespace treelet {

/// The normal of length one to whose tip the corners turn counter-clockwise, each coordinate right
/// to 2^-19 of itself before it is rounded to float. NaN for a triangle without area.
Vec3 unit_normal(const Triangle& triangle);

/// An origin for a ray of this direction that leaves the point (1-u-v) P0 + u P1 + v P2 of a
/// triangle: beside the point, on the side to which the ray goes, and so far that no query from
/// t = 0 on reports the triangle again.
///
/// As [WachterBinder2019] it is found from the point and moved along the normal, and as
/// [PharrJakobHumphreys2023 s6.8] by a bound on rounding instead of a constant. Differs: what there
/// is to outweigh is the rounding of t in traverse/ray_triangle_steps.h alone, which is below
/// 2^-24.4 of the triangle's size, and not that of a point far along a ray: the point is
/// interpolated in doubles, and its rounding to float goes towards the side too. So the origin
/// moves by 2^-22 of the triangle's extent, and a float.
///
/// `far` is the largest magnitude of an offset that is added to the origin in doubles, and
/// subtracted again before a query; 0 for none.
Vec3 spawn_origin(const Triangle& triangle, float u, float v, Vec3 direction, double far = 0.0);

}  // namespace treelet
