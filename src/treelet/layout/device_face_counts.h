#pragma once

#include <cstdint>

#include <treelet/core/carver.h>
#include <treelet/core/stream.h>
#include <treelet/primitive/device_references.h>
#include <treelet/primitive/device_sort.h>
#include <treelet/tree/device_cut.h>
#include <treelet/tree/device_tree.h>
#include <treelet/tree/subtree_faces.h>

namespace treelet::cuda {

/// What counting needs besides the result: 28 bytes a reference and what the sort takes.
struct FaceCountScratch {
  std::uint32_t* begin = nullptr;   ///< by pair: leaves to the left of it
  std::uint64_t* keys = nullptr;    ///< of leaves: face, then place in leaf order
  std::uint32_t* leaves = nullptr;  ///< slots
  SortScratch sort{};
};
FaceCountScratch carve_face_count_scratch(Carver& carver, std::uint32_t capacity);

/// Room for the result, which is needed until the layout is written: 8 bytes a reference.
SubtreeFaces carve_subtree_faces(Carver& carver, std::uint32_t capacity);

/// As FaceCounts on the host (layout/face_counts.h), of a tree over split references.
void count_faces(const DeviceTree& tree, const DeviceCut& cut, const DeviceReferences& references,
                 const FaceCountScratch& scratch, const SubtreeFaces& faces, Stream stream);

}  // namespace treelet::cuda
