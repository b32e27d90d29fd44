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

/// Reads "low", "medium" or "high". Throws std::invalid_argument.
RTCBuildQuality parse_embree_quality(std::string_view word);
/// The word that gives this quality.
std::string_view embree_quality_word(RTCBuildQuality quality);

/// Takes the word before the next '+' off the text.
std::string_view take_word(std::string_view& text);

/// Reads "embree:low", "embree:medium" or "embree:high", with "+robust" or "+compact" behind it.
/// Throws std::invalid_argument.
EmbreeOptions parse_embree_options(std::string_view text);

}  // namespace treelet::peers
