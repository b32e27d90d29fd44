#pragma once

#include <string>
#include <string_view>

#include "peers/embree_options.h"

namespace treelet::peers {

/// How Embree's builder is asked for a tree of this library.
struct EmbreeTreeOptions {
  RTCBuildQuality quality = RTC_BUILD_QUALITY_HIGH;
  int budget =
      20;  ///< references that splits add at most, in percent; 20 is Embree's own for scenes
  int block =
      1;  ///< counts of references are rounded up to multiples of it when costs are compared

  /// As "Embree HIGH's tree".
  std::string label() const;
  /// The text that gives these options.
  std::string text() const;
};

inline constexpr std::string_view kEmbreeTreePrefix = "embree-tree:";

/// Reads "embree-tree:low", "embree-tree:medium" or "embree-tree:high", with "+budget=100" or
/// "+block=4" behind it. Throws std::invalid_argument.
EmbreeTreeOptions parse_embree_tree_options(std::string_view text);

}  // namespace treelet::peers
