#include <treelet/core/cuda_device.h>

#include <gtest/gtest.h>

#include <treelet/core/cuda_check.cuh>

#if __has_include(<emulator/control.h>)
#include <emulator/control.h>
#endif

#include <string>

#include "support/errors.h"

namespace treelet::cuda {
namespace {

TEST(CudaDevice, IsAvailableWhereTheseTestsRun) {
  EXPECT_TRUE(is_compiled_in());
  EXPECT_TRUE(is_available());
  EXPECT_EQ(why_unavailable(), "");
}

TEST(CudaDevice, IsDescribed) {
  ASSERT_FALSE(devices().empty());
  for (const DeviceInfo& device : devices()) {
    EXPECT_FALSE(device.name.empty());
    EXPECT_GE(device.capability_major, 5);
    EXPECT_GT(device.bytes, std::size_t{1} << 28);
    EXPECT_GT(device.multiprocessors, 0);
  }
}

#if __has_include(<emulator/control.h>)
TEST(CudaDevice, OfWhichThereIsNoneIsAnAnswer) {
  emulator::Settings settings = emulator::settings();
  settings.has_device = false;
  const emulator::SettingsScope scope(settings);
  EXPECT_FALSE(is_available());
  EXPECT_NE(why_unavailable().find("no GPU"), std::string::npos) << why_unavailable();
  EXPECT_TRUE(devices().empty());
  EXPECT_EQ(test::error_of<CudaError>([] { check(cudaErrorNoDevice, "hum"); }),
            "could not hum: " + why_unavailable());
}
#endif

}  // namespace
}  // namespace treelet::cuda
