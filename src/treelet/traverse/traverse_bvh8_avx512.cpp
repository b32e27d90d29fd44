#define TREELET_ISA avx512
#include <treelet/traverse/traverse_bvh8_kernel.inl>
