#pragma once

#include <string>
#include <string_view>

#include "peers/embree_api.h"

namespace treelet::peers {

/// How Embree is asked to build and trace.
struct EmbreeOptions {
  RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM;
  bool is_robust = false;   ///< with high quality: also without spatial splits
  bool is_compact = false;  ///< smaller and slower

  RTCSceneFlags flags() const;
  /// As "Embree HIGH robust".
  std::string label() const;
  /// The text that gives these options.
  std::string text() const;
};

inline constexpr std::string_view kEmbreePrefix = "embree:";

/// Reads "embree:low", "embree:medium" or "embree:high", with "+robust" or "+compact" behind it.
/// Throws std::invalid_argument.
EmbreeOptions parse_embree_options(std::string_view text);

}  // namespace treelet::peers
