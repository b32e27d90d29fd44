#include <treelet/optimize/treelet_batch.h>

namespace treelet {

// Defined by treelet_batch_kernel.inl in one file an instruction set.
#define TREELET_DECLARE_KERNELS(isa)                                                        \
  namespace isa {                                                                           \
  void form_treelet_batch(const BinaryNode*, const float*, const SahModel&, TreeletBatch&); \
  void solve_treelet_batch(const TreeletBatch&, const SahModel&, SolvedBatch&);             \
  void update_costs(const BinaryNode*, const std::uint32_t*, const SahModel&, float*);      \
  constexpr TreeletKernels kKernels{form_treelet_batch, solve_treelet_batch, update_costs}; \
  }
TREELET_DECLARE_KERNELS(baseline)
TREELET_DECLARE_KERNELS(avx2)
TREELET_DECLARE_KERNELS(avx512)
#undef TREELET_DECLARE_KERNELS

TreeletKernels treelet_kernels(Isa isa) {
  switch (isa) {
    case Isa::avx512:
      return avx512::kKernels;
    case Isa::avx2:
      return avx2::kKernels;
    case Isa::baseline:
      break;
  }
  return baseline::kKernels;
}

}  // namespace treelet
