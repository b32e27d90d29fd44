#pragma once

#include <memory>
#include <vector>

#include "block_state.h"

namespace treelet::emulator {

/// As many as the sanitizers bear.
unsigned max_workers();

/// The block state of a worker and the stacks of its threads, made when first needed.
class WorkerStacks {
 public:
  WorkerStacks();
  ~WorkerStacks();
  WorkerStacks(const WorkerStacks&) = delete;
  WorkerStacks& operator=(const WorkerStacks&) = delete;

  BlockState& block_for(unsigned threads);

 private:
  std::unique_ptr<BlockState> block_;
  std::vector<void*> stacks_;
};

}  // namespace treelet::emulator
