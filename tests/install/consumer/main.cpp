#include <treelet/treelet.h>

#include <array>
#include <cstdio>

/// A unit square in z = 2, hit by a ray along z and missed by one beside it.
int main() {
  const std::array<treelet::Vec3, 4> vertices{{{0, 0, 2}, {1, 0, 2}, {1, 1, 2}, {0, 1, 2}}};
  const std::array<treelet::Face, 2> faces{{{0, 1, 2}, {0, 2, 3}}};
  const treelet::Bvh bvh = treelet::build({vertices, faces});

  const treelet::Hit hit = bvh.intersect({.origin = {0.75f, 0.25f, 0}, .direction = {0, 0, 1}});
  const bool beside = bvh.is_occluded({.origin = {2, 2, 0}, .direction = {0, 0, 1}});
  std::printf("t %g, face %d, u %g, v %g\n", double(hit.t), int(hit.face), double(hit.u),
              double(hit.v));
  return hit == treelet::Hit{2, 0, 0.5f, 0.25f} && !beside ? 0 : 1;
}
