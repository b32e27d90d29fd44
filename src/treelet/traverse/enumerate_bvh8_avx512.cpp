#define TREELET_ISA avx512
#include <treelet/traverse/enumerate_bvh8_kernel.inl>
