#pragma once

#include <cstddef>

#include <treelet/mesh/mesh.h>
#include <treelet/primitive/reference.h>

namespace treelet {

/// Splits the triangles whose boxes are much larger than themselves into pieces, each a reference
/// with a box of its own [KarrasAila2013 s4]. At most `budget` references are added; the pieces of
/// a triangle cover it. Keeps face order. References must be whole triangles of the mesh.
void split_references(References& references, const Mesh& mesh, std::size_t budget);

}  // namespace treelet
