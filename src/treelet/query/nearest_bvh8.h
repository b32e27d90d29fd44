#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/isa.h>
#include <treelet/query/nearest.h>
#include <treelet/traverse/traverse_bvh8.h>

namespace treelet {

/// The search of query/nearest.h in the wide layout as compiled for one instruction set: an answer
/// for each of `count` queries, whose points are finite. The tree must have nodes. The answers are
/// the same bits for all.
using Bvh8NearestSearch = void (*)(const Bvh8View& bvh, const NearestQuery* queries,
                                   std::size_t count, Nearest* answers,
                                   const WaveStacks::View& stacks);

Bvh8NearestSearch bvh8_nearest_search(Isa isa);

}  // namespace treelet
