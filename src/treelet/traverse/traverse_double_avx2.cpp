#define TREELET_ISA avx2
#include <treelet/traverse/traverse_double_kernel.inl>
