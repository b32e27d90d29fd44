#define TREELET_ISA baseline
#include <treelet/traverse/traverse_double_kernel.inl>
