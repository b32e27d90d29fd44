#define TREELET_ISA avx2
#include <treelet/layout/wide_collapse_lanes.inl>
