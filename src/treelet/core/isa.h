#pragma once

namespace treelet {

/// Instruction sets that kernels are compiled for. Files named *_avx2.cpp and *_avx512.cpp get
/// their flags from CMake; on other processors they are compiled like the baseline.
enum class Isa { baseline, avx2, avx512 };

/// The best one that this processor runs.
Isa best_isa();

}  // namespace treelet
