#include "peers/embree_options.h"

#include <stdexcept>

namespace treelet::peers {
namespace {

constexpr std::string_view kQualities[] = {"low", "medium", "high"};  // by Embree's numbers
constexpr std::string_view kLabels[] = {"Embree LOW", "Embree MEDIUM", "Embree HIGH"};

void set_flag(EmbreeOptions& options, std::string_view word) {
  if (word == "robust") {
    options.is_robust = true;
  } else if (word == "compact") {
    options.is_compact = true;
  } else {
    throw std::invalid_argument("unknown flag '" + std::string(word) +
                                "' of Embree: choose from robust, compact");
  }
}

}  // namespace

RTCBuildQuality parse_embree_quality(std::string_view word) {
  for (int i = 0; i < 3; ++i) {
    if (word == kQualities[i]) return RTCBuildQuality(i);
  }
  throw std::invalid_argument("Embree has no quality '" + std::string(word) +
                              "': choose from low, medium, high");
}

std::string_view embree_quality_word(RTCBuildQuality quality) { return kQualities[quality]; }

std::string_view take_word(std::string_view& text) {
  const std::size_t end = text.find('+');
  const std::string_view word = text.substr(0, end);
  text = end == text.npos ? "" : text.substr(end + 1);
  return word;
}

RTCSceneFlags EmbreeOptions::flags() const {
  return RTCSceneFlags((is_robust ? RTC_SCENE_FLAG_ROBUST : 0) |
                       (is_compact ? RTC_SCENE_FLAG_COMPACT : 0));
}

std::string EmbreeOptions::label() const {
  return std::string(kLabels[quality]) + (is_robust ? " robust" : "") +
         (is_compact ? " compact" : "");
}

std::string EmbreeOptions::text() const {
  return std::string(kEmbreePrefix) + std::string(embree_quality_word(quality)) +
         (is_robust ? "+robust" : "") + (is_compact ? "+compact" : "");
}

EmbreeOptions parse_embree_options(std::string_view text) {
  text.remove_prefix(kEmbreePrefix.size());
  EmbreeOptions options;
  options.quality = parse_embree_quality(take_word(text));
  while (!text.empty()) set_flag(options, take_word(text));
  return options;
}

}  // namespace treelet::peers
