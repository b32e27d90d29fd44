// What a batch of treelets goes through, one treelet a lane; see core/lanes.inl for how it is
// included and what it must not call.

#include <treelet/optimize/treelet_batch.h>
#include <treelet/optimize/treelet_batch_forming.inl>
#include <treelet/optimize/treelet_batch_solving.inl>

namespace treelet::TREELET_ISA {

void update_costs(const BinaryNode* nodes, const std::uint32_t* slots, const SahModel& sah,
                  float* costs) {
  const SahLanes lanes = broadcast_sah(sah);
  for (int lane = 0; lane < TreeletBatch::kTreelets; lane += kLanes) {
    update_lanes(nodes, slots + lane, lanes, costs);
  }
}

void form_treelet_batch(const BinaryNode* nodes, const float* costs, const SahModel& sah,
                        TreeletBatch& batch) {
  const SahLanes lanes = broadcast_sah(sah);
  for (int lane = 0; lane < TreeletBatch::kTreelets; lane += kLanes) {
    form_lanes(nodes, costs, lanes, lane, batch);
  }
}

void solve_treelet_batch(const TreeletBatch& batch, const SahModel& sah, SolvedBatch& solved) {
  switch (batch.size) {
    case 4:
      return solve_all_lanes<4>(batch, sah, solved);
    case 5:
      return solve_all_lanes<5>(batch, sah, solved);
    case 6:
      return solve_all_lanes<6>(batch, sah, solved);
    case 7:
      return solve_all_lanes<7>(batch, sah, solved);
    default:
      return solve_all_lanes<8>(batch, sah, solved);
  }
}

}  // namespace treelet::TREELET_ISA
