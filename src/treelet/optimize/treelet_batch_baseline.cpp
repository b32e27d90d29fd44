#define TREELET_ISA baseline
#include <treelet/optimize/treelet_batch_kernel.inl>
