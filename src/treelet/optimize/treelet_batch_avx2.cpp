#define TREELET_ISA avx2
#include <treelet/optimize/treelet_batch_kernel.inl>
