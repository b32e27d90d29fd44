#pragma once

#include <cstdint>

#include <treelet/core/carver.h>
#include <treelet/core/stream.h>
#include <treelet/layout/device_collapse.h>
#include <treelet/layout/device_layout.h>
#include <treelet/layout/device_refit_layout.h>
#include <treelet/layout/pack_cwbvh.h>
#include <treelet/layout/wide_collapse.h>
#include <treelet/primitive/device_references.h>
#include <treelet/tree/device_cut.h>
#include <treelet/tree/device_tree.h>
#include <treelet/tree/sah.h>

// Packing in two calls: planning finds out what the layout takes, writing fills its arrays. Who
// wants arrays of just that size reads the planned one in between, which waits for the device; who
// packs again and again gives arrays that are large enough. What does not fit is not written and
// the layout is empty (LayoutSummary::overflowed).
//
// The bytes are those of pack_bvh2, pack_bvh8 and pack_cwbvh on the host.

namespace treelet::cuda {

/// A tree to pack, and what it was built over.
struct PackInput {
  DeviceTree tree;
  DeviceCut cut;
  DeviceReferences references;
  SubtreeFaces faces{};  ///< where references are split: counted (layout/device_face_counts.h)
};

/// An entry a reference.
template <class Layout, class DecisionEntry>
struct PackScratch {
  using Entry = DecisionEntry;

  Entry* entries = nullptr;
  LinkOf<Layout>* links = nullptr;  ///< in the place of the entries, which are read by then
  LayoutSize* size = nullptr;       ///< what is planned
};
using Bvh2Scratch = PackScratch<DeviceBvh2, LeafEntry>;
using Bvh8Scratch = PackScratch<DeviceBvh8, WideEntry>;
using CwbvhScratch = PackScratch<DeviceCwbvh, WideEntry>;

Bvh2Scratch carve_bvh2_scratch(Carver& carver, std::uint32_t capacity);
Bvh8Scratch carve_bvh8_scratch(Carver& carver, std::uint32_t capacity);
CwbvhScratch carve_cwbvh_scratch(Carver& carver, std::uint32_t capacity);

/// Throws std::invalid_argument for leaves that the layout cannot hold: of bvh2 1 to 64 triangles,
/// of bvh8 1 to 16, of cwbvh 1 to 3. Planning a bvh2 uses up the counts of faces: who plans again
/// counts again.
void plan_bvh2(const PackInput& input, const SahModel& sah, const Bvh2Scratch& scratch,
               Stream stream);
void plan_bvh8(const PackInput& input, const WideCostModel& model, const Bvh8Scratch& scratch,
               Stream stream);
void plan_cwbvh(const PackInput& input, const CwbvhCostModel& model, const CwbvhScratch& scratch,
                Stream stream);

void write_bvh2(const PackInput& input, const Bvh2Scratch& scratch, const DeviceBvh2& bvh,
                Stream stream);
void write_bvh8(const PackInput& input, const Bvh8Scratch& scratch, const DeviceBvh8& bvh,
                Stream stream);
void write_cwbvh(const PackInput& input, const CwbvhScratch& scratch, const DeviceCwbvh& bvh,
                 Stream stream);

}  // namespace treelet::cuda
