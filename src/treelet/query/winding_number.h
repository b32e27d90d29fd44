#pragma once

#include <treelet/query/point_batch.h>
#include <treelet/query/winding_moments.h>

namespace treelet {

/// The generalised winding numbers of points [JacobsonEtAl2013], one each, on all threads: the
/// solid angle of the mesh over 4 pi, positive where the faces' normals point away. For a closed
/// mesh it is an integer, 1 inside if its faces are counterclockwise from outside; for an open one
/// it says how much a point is inside.
///
/// A cluster whose centre is farther than `accuracy` of its radii is seen as a dipole, quadrupole
/// and octupole [BarillEtAl2018]; an infinite accuracy sums all triangles, in doubles. NaN for
/// points that are not finite.
template <class Layout>
void winding_number(const Layout& bvh, const WindingMoments& moments, const PointBatch& points,
                    float accuracy, float* answers);

}  // namespace treelet
