#define TREELET_ISA baseline
#include <treelet/traverse/traverse_bvh8_kernel.inl>
