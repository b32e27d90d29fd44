#define TREELET_ISA avx2
#include <treelet/traverse/enumerate_bvh8_kernel.inl>
