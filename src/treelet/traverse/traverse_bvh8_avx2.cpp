#define TREELET_ISA avx2
#include <treelet/traverse/traverse_bvh8_kernel.inl>
