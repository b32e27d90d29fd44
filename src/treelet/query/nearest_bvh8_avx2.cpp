#define TREELET_ISA avx2
#include <treelet/query/nearest_bvh8_kernel.inl>
