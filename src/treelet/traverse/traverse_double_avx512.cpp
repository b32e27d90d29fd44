#define TREELET_ISA avx512
#include <treelet/traverse/traverse_double_kernel.inl>
