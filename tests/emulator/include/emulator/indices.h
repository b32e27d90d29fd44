#pragma once

#include "emulator/vector_types.h"

// Set whenever a thread goes on. TLS that needs no initialisation is read without a call.

extern thread_local constinit uint3 threadIdx;
extern thread_local constinit uint3 blockIdx;
extern thread_local constinit dim3 blockDim;
extern thread_local constinit dim3 gridDim;
constexpr int warpSize = 32;
