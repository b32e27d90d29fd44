#define TREELET_ISA avx512
#include <treelet/optimize/treelet_batch_kernel.inl>
