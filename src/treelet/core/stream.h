#pragma once

struct CUstream_st;

namespace treelet::cuda {

/// A CUDA stream, the same as cudaStream_t; null is the default stream. What is enqueued on one
/// stream runs in order.
using Stream = CUstream_st*;

}  // namespace treelet::cuda
