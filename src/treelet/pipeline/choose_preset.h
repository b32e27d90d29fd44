#pragma once

#include <cstddef>
#include <string_view>

namespace treelet {

/// The preset that is expected to build a tree over so many triangles and trace so many diffuse
/// rays through it in the least time: build time a triangle and time a ray as measured on the CPU
/// (docs/benchmarks.md). NaN and negative numbers count as no rays.
std::string_view choose_preset(std::size_t triangles, double rays);
/// Likewise among presets that split no triangles, for what cannot have pieces: trees to be
/// refitted, and those that are built on a CUDA device.
std::string_view choose_unsplit_preset(std::size_t triangles, double rays);

}  // namespace treelet
