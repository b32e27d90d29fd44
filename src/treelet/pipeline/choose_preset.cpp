#include <treelet/pipeline/choose_preset.h>

#include <algorithm>
#include <array>
#include <span>

namespace treelet {
namespace {

/// Nanoseconds on two cores: geometric means over the scenes of bench/results/peers.
struct PresetCost {
  std::string_view name;
  double build;  ///< a triangle
  double ray;    ///< a diffuse ray's closest hit
};

constexpr std::array<PresetCost, 4> kCosts{{{"fast", 67.0, 163.0},
                                            {"balanced", 119.0, 131.0},
                                            {"better", 808.0, 114.0},
                                            {"best", 1374.0, 107.0}}};

std::string_view find_cheapest(std::span<const PresetCost> costs, std::size_t triangles,
                               double rays) {
  constexpr double kMany = 1e30;  // an infinity would make all equal
  const double traced = rays > 0.0 ? std::min(rays, kMany) : 0.0;
  const auto total = [&](const PresetCost& cost) {
    return cost.build * double(triangles) + cost.ray * traced;
  };
  return std::min_element(
             costs.begin(), costs.end(),
             [&](const PresetCost& a, const PresetCost& b) { return total(a) < total(b); })
      ->name;
}

}  // namespace

std::string_view choose_preset(std::size_t triangles, double rays) {
  return find_cheapest(kCosts, triangles, rays);
}

std::string_view choose_unsplit_preset(std::size_t triangles, double rays) {
  return find_cheapest(std::span(kCosts).first(2), triangles, rays);
}

}  // namespace treelet
