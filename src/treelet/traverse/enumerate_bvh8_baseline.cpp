#define TREELET_ISA baseline
#include <treelet/traverse/enumerate_bvh8_kernel.inl>
