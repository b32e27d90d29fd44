#include <treelet/core/use_log.h>

#include <treelet/core/no_cuda.h>

namespace treelet::cuda {

UseLog::~UseLog() = default;

Stream own_stream() { throw_no_cuda(); }

}  // namespace treelet::cuda
