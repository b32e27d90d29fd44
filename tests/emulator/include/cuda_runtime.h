#pragma once

// Stands in for CUDA's header of the same name, so that a C++ compiler builds .cu files and the
// host runs their kernels. See tests/emulator/README.md.

#define TREELET_EMULATED_CUDA 1

#include <cassert>
#include <cmath>
#include <cstdio>

#include "emulator/atomics.h"
#include "emulator/attributes.h"
#include "emulator/graphs.h"
#include "emulator/indices.h"
#include "emulator/integer_intrinsics.h"
#include "emulator/launch.h"
#include "emulator/math_intrinsics.h"
#include "emulator/memory_api.h"
#include "emulator/nv_atomics.h"
#include "emulator/runtime_api.h"
#include "emulator/runtime_types.h"
#include "emulator/vector_types.h"
#include "emulator/warp.h"
