#pragma once

#include <vector>

#include <treelet/core/isa.h>

namespace treelet::test {

/// The instruction sets that this processor has.
inline std::vector<Isa> runnable_isas() {
  std::vector<Isa> isas;
  for (const Isa isa : {Isa::baseline, Isa::avx2, Isa::avx512}) {
    if (isa <= best_isa()) isas.push_back(isa);
  }
  return isas;
}

}  // namespace treelet::test
