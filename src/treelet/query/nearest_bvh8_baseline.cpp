#define TREELET_ISA baseline
#include <treelet/query/nearest_bvh8_kernel.inl>
