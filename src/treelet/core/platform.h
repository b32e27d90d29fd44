#pragma once

/// Marks a step that host loops and device kernels share.
#if defined(__CUDACC__)
#define TREELET_HD __host__ __device__
#else
#define TREELET_HD
#endif
