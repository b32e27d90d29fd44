#include <treelet/pipeline/choose_preset.h>

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace treelet {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(ChoosePreset, SpendsMoreOnTheTreeTheMoreRaysThereAre) {
  std::vector<std::string> chosen;
  for (double rays = 0.0; rays < 1e12; rays = 1.5 * rays + 1.0) {
    const std::string preset(choose_preset(1'000'000, rays));
    if (chosen.empty() || chosen.back() != preset) chosen.push_back(preset);
  }
  EXPECT_EQ(chosen, (std::vector<std::string>{"fast", "balanced", "better", "best"}));
}

TEST(ChoosePreset, CountsRaysATriangle) {
  for (const double rays_a_triangle : {0.1, 1.0, 3.0, 10.0, 30.0, 100.0, 1000.0}) {
    EXPECT_EQ(choose_preset(1'000, 1e3 * rays_a_triangle),
              choose_preset(10'000'000, 1e7 * rays_a_triangle));
  }
}

TEST(ChoosePreset, OfNoRaysIsTheQuickestBuild) {
  EXPECT_EQ(choose_preset(1000, 0.0), "fast");
  EXPECT_EQ(choose_preset(1000, -1.0), "fast");
  EXPECT_EQ(choose_preset(1000, std::numeric_limits<double>::quiet_NaN()), "fast");
}

TEST(ChoosePreset, OfNoTrianglesIsAPreset) { EXPECT_FALSE(choose_preset(0, 1e9).empty()); }

TEST(ChoosePreset, WithoutPiecesIsNeverTheBest) {
  EXPECT_EQ(choose_unsplit_preset(1000, 0.0), "fast");
  EXPECT_EQ(choose_unsplit_preset(1000, 1e15), "balanced");
  EXPECT_EQ(choose_preset(1000, 1e15), "best");
  EXPECT_EQ(choose_preset(1000, kInfinity), "best");
  EXPECT_EQ(choose_unsplit_preset(1000, kInfinity), "balanced");
}

}  // namespace
}  // namespace treelet
