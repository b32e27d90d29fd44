#include <treelet/core/stage.h>

#include <gtest/gtest.h>

#include <string>
#include <thread>

namespace treelet {
namespace {

std::vector<std::string> names(const StageRecorder& recorder) {
  std::vector<std::string> result;
  for (const StageTime& stage : recorder.stages()) result.emplace_back(stage.name);
  return result;
}

using Names = std::vector<std::string>;

TEST(Stage, IsRecordedInTheOrderOfEnds) {
  StageRecorder recorder;
  {
    const Stage outer{"outer"};
    {
      const Stage inner{"inner"};
    }
    EXPECT_EQ(names(recorder), Names{"inner"});
  }
  {
    const Stage after{"after"};
  }
  EXPECT_EQ(names(recorder), (Names{"inner", "outer", "after"}));
}

TEST(Stage, MeasuresItsScope) {
  StageRecorder recorder;
  const auto start = std::chrono::steady_clock::now();
  {
    const Stage stage{"sleep"};
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const std::chrono::duration<double> around = std::chrono::steady_clock::now() - start;
  EXPECT_GE(recorder.stages().at(0).seconds, 0.005);
  EXPECT_LE(recorder.stages().at(0).seconds, around.count());
}

TEST(Stage, IsNotRecordedWhereNobodyListens) {
  {
    const Stage stage{"unheard"};
  }
  const StageRecorder recorder;
  EXPECT_TRUE(recorder.stages().empty());
}

TEST(StageRecorder, OnlyTheInnermostListens) {
  StageRecorder outer;
  {
    StageRecorder inner;
    {
      const Stage stage{"inside"};
    }
    EXPECT_EQ(names(inner), Names{"inside"});
  }
  {
    const Stage stage{"outside"};
  }
  EXPECT_EQ(names(outer), Names{"outside"});
}

TEST(StageRecorder, ListensToItsOwnThread) {
  StageRecorder here;
  Names there;
  std::thread thread([&] {
    {
      const Stage stage{"before"};
    }
    const StageRecorder recorder;
    {
      const Stage stage{"during"};
    }
    there = names(recorder);
  });
  thread.join();
  EXPECT_EQ(there, Names{"during"});
  EXPECT_TRUE(here.stages().empty());
}

}  // namespace
}  // namespace treelet
