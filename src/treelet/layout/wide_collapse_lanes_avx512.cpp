#define TREELET_ISA avx512
#include <treelet/layout/wide_collapse_lanes.inl>
