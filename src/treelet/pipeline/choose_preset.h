#pragma once

#include <cstddef>
#include <string_view>

namespace treelet {

/// The preset that is expected to build a tree over so many triangles and trace so many diffuse
/// rays through it in the least time: build time a triangle and time a ray as measured on the CPU
/// (docs/benchmarks.md). NaN and negative numbers count as no rays. On a CUDA device, where `best`
/// cannot be built, one of the other two.
std::string_view choose_preset(std::size_t triangles, double rays);
std::string_view choose_device_preset(std::size_t triangles, double rays);

}  // namespace treelet
