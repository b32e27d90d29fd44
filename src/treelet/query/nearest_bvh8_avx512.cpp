#define TREELET_ISA avx512
#include <treelet/query/nearest_bvh8_kernel.inl>
