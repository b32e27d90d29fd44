#pragma once

/// The whole of treelet's C++ interface. Start with build() in pipeline/build.h.

#include <treelet/core/aabb.h>
#include <treelet/core/cuda_device.h>
#include <treelet/core/cuda_error.h>
#include <treelet/core/device_memory.h>
#include <treelet/core/parallel.h>
#include <treelet/core/ray.h>
#include <treelet/core/vec.h>
#include <treelet/file/load.h>
#include <treelet/file/save.h>
#include <treelet/layout/epo.h>
#include <treelet/layout/validate_layout.h>
#include <treelet/mesh/double_mesh.h>
#include <treelet/mesh/mesh.h>
#include <treelet/pipeline/build.h>
#include <treelet/pipeline/bvh.h>
#include <treelet/pipeline/choose_preset.h>
#include <treelet/pipeline/device_bvh.h>
#include <treelet/pipeline/double_bvh.h>
#include <treelet/pipeline/recipe.h>
#include <treelet/pipeline/update.h>
#include <treelet/query/all_hits.h>
#include <treelet/query/closest_point.h>
#include <treelet/query/double_queries.h>
#include <treelet/query/hit_counts.h>
#include <treelet/query/intersect.h>
#include <treelet/query/overlap.h>
