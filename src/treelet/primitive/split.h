#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/carver.h>
#include <treelet/core/stream.h>
#include <treelet/mesh/mesh.h>
#include <treelet/primitive/device_references.h>
#include <treelet/primitive/device_sort.h>
#include <treelet/primitive/reference.h>

namespace treelet {

/// Splits the triangles whose boxes are much larger than themselves into pieces, each a reference
/// with a box of its own [KarrasAila2013 s4]. At most `budget` references are added; the pieces of
/// a triangle cover it. Keeps face order. References must be whole triangles of the mesh.
void split_references(References& references, const Mesh& mesh, std::size_t budget);

struct FactorSearch;

namespace cuda {

/// References at most, for a budget in percent of the regular triangles.
std::uint32_t split_capacity(std::uint32_t faces, std::uint32_t percent);

/// What splitting needs besides the references: 8 bytes a face and a few hundred KiB.
struct SplitScratch {
  float* priorities;      // of each face, below 0 if it is left out
  float* largest;         // priority, of each block
  std::uint64_t* splits;  // a row for each block, a column for each candidate
  FactorSearch* search;
  std::uint32_t* offsets;  // first reference of each face; behind the last, how many there are
  SumScratch sum;
};
SplitScratch carve_split_scratch(Carver& carver, std::uint32_t faces);

/// Writes the host's references, to the byte, and their number to `scene`, which must be that of
/// the mesh, surveyed. `references` has room for split_capacity().
void split_references(const DeviceMesh& mesh, std::uint32_t percent, const SplitScratch& scratch,
                      DeviceScene* scene, Reference* references, Stream stream);

}  // namespace cuda
}  // namespace treelet
