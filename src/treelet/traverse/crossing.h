#pragma once

#include <treelet/core/ray.h>
#include <treelet/mesh/mesh.h>
#include <treelet/traverse/ray_triangle.h>

// When a ray crosses a surface: the rule by which hits are counted. A closest hit may lie on an
// edge and belongs to all triangles there (traverse/ray_triangle.h); here it belongs to just one of
// two that the surface passes through, and to none or two where the surface turns back.
//
// The rule is that of a ray displaced by (e, e^2) in the sheared plane, for an e > 0 so small that
// no smaller one would give another answer [EdelsbrunnerMuecke1990]. No edge function of the
// displaced ray is zero, unless the edge is parallel to the ray: moving the ray adds
//
//     e (Yq - Yp) - e^2 (Xq - Xp)     to     Xq Yp - Yq Xp
//
// so where that is zero the first difference of the edge's sheared ends that is not decides, the
// sign of both computed exactly. The displaced ray is a line like any other, of which it does not
// matter that it is not known: it meets a closed surface, one whose edges have an even number of
// triangles each, an even number of times, and as often before a point as winding around the point
// says. A triangle seen edge-on has sheared corners on one line, which passes beside (e, e^2) for
// small e: it counts zero. What the displaced ray crosses, the ray itself meets: in the limit a
// point in the triangle's inside, on its edge or vertex.
//
// Where the ray meets the triangle does not move. The sign of t is exact: t is zero where the
// origin lies on the triangle, and nowhere else. So with limits [0, inf] a ray starts just before
// its origin, and the parity of its crossings is that of the origin, for every origin not on the
// surface.

namespace treelet {

/// Whether the ray's whole line crosses the triangle, and where: t, u and v are those of
/// intersect_exactly, but t is moved by one denormal where it would have the wrong sign. t is
/// infinite where it exceeds the largest float.
bool cross(const RayShear& ray, const Triangle& triangle, TriangleHit& hit);

/// Whether a crossing counts: its t lies between the ray's limits, both included. Unlike a closest
/// hit it does where t exceeds the largest float and t_max is infinite.
TREELET_HD inline bool is_within_limits(const Ray& ray, const TriangleHit& hit) {
  return hit.t >= ray.t_min && hit.t <= ray.t_max;
}

}  // namespace treelet
