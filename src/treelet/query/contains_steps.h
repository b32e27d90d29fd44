#pragma once

#include <treelet/core/vec.h>

namespace treelet {

/// The direction of the rays that tell inside from outside. Nearly along an axis, which meets few
/// boxes; but not quite, for many meshes have faces and edges along axes, which take exact
/// arithmetic. Crossings at the origin count as ahead of it, so it is the side that the ray comes
/// from that decides: larger coordinates.
inline constexpr Vec3 kContainsDirection{-1.0f, -0x1p-7f, -0x1p-8f};

}  // namespace treelet
