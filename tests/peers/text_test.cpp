#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "peers/arguments.h"
#include "peers/embree_options.h"
#include "peers/json.h"

namespace treelet::peers {
namespace {

TEST(EmbreeOptions, ReadsWhatItWrites) {
  for (const char* text : {"embree:low", "embree:medium+robust", "embree:high+robust+compact"}) {
    EXPECT_EQ(parse_embree_options(text).text(), text);
  }
  EXPECT_EQ(parse_embree_options("embree:high+compact").label(), "Embree HIGH compact");
  EXPECT_EQ(parse_embree_options("embree:low+robust").flags(), RTC_SCENE_FLAG_ROBUST);
  EXPECT_EQ(parse_embree_options("embree:high").quality, RTC_BUILD_QUALITY_HIGH);
}

TEST(EmbreeOptions, RefusesUnknownWords) {
  for (const char* text : {"embree:", "embree:best", "embree:high+fast", "embree:high++robust"}) {
    EXPECT_THROW(parse_embree_options(text), std::invalid_argument) << text;
  }
}

TEST(JsonObject, IsJsonWhateverItHolds) {
  JsonObject inner;
  inner.add("a \"quoted\"\\\n", "\x01");
  const std::vector<double> samples = {0.5, 1e6, -3, 1e-7};
  JsonObject object;
  object.add("inner", inner);
  object.add("samples", samples);
  object.add("none", std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(object.text(), R"({"inner": {"a \"quoted\"\\\u000a": "\u0001"}, )"
                           R"("samples": [0.5, 1000000, -3, 1e-07], "none": null})");
  EXPECT_EQ(JsonObject().text(), "{}");
}

TEST(Arguments, ReadsEveryOption) {
  const Arguments arguments =
      parse_arguments({"--builds=2", "a.scene", "--repeats=3", "--contender=fast",
                       "--contender=lbvh > treelet(size=8) > bvh8", "--threads=4"});
  EXPECT_EQ(arguments.scene, "a.scene");
  EXPECT_EQ(arguments.plan.builds, 2);
  EXPECT_EQ(arguments.plan.repeats, 3);
  EXPECT_EQ(arguments.threads, 4u);
  EXPECT_EQ(arguments.contenders,
            (std::vector<std::string>{"fast", "lbvh > treelet(size=8) > bvh8"}));
}

TEST(Arguments, RacesPresetsAndEveryEmbreeByDefault) {
  EXPECT_EQ(parse_arguments({"a.scene"}).contenders.size(), 8u);
}

TEST(Arguments, RefusesMistakes) {
  const std::vector<std::vector<std::string>> mistakes = {
      {},
      {"a", "b"},
      {"a", "--builds"},
      {"a", "--builds=0"},
      {"a", "--builds=2x"},
      {"a", "--build=2"},
  };
  for (const auto& words : mistakes) EXPECT_THROW(parse_arguments(words), std::invalid_argument);
}

}  // namespace
}  // namespace treelet::peers
