#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include "launching.h"

// Streams, events and graphs.

namespace treelet::emulator::test {
namespace {

using Wide = unsigned long long;

class Stream {
 public:
  explicit Stream(unsigned flags = cudaStreamNonBlocking) {
    EXPECT_EQ(cudaStreamCreateWithFlags(&handle_, flags), cudaSuccess);
  }
  ~Stream() { cudaStreamDestroy(handle_); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  operator cudaStream_t() const { return handle_; }

 private:
  cudaStream_t handle_ = nullptr;
};

__global__ void append_digit(unsigned long long* number, unsigned digit) {
  *number = *number * 10 + digit;
}

cudaError_t append(unsigned long long* number, unsigned digit, cudaStream_t stream) {
  cudaLaunchConfig_t config{};
  config.gridDim = config.blockDim = 1;
  config.stream = stream;
  return cudaLaunchKernelEx(&config, append_digit, number, digit);
}

TEST(Streams, RunInOrderOnceSomeoneWaits) {
  Buffer<Wide> number(std::vector<Wide>{0});
  const Stream stream;
  const std::uint64_t before = launch_count();
  for (unsigned digit = 1; digit <= 5; ++digit) append(number.data(), digit, stream);
  EXPECT_EQ(launch_count(), before);
  EXPECT_EQ(cudaStreamQuery(stream), cudaErrorNotReady);
  EXPECT_EQ(cudaStreamQuery(stream), cudaSuccess);
  EXPECT_EQ(launch_count(), before + 5);
  EXPECT_EQ(number.read()[0], 12345u);
}

TEST(Streams, BlockingOnesAndTheDefaultOneWaitForEachOther) {
  Buffer<Wide> number(std::vector<Wide>{0});
  const Stream stream(cudaStreamDefault);
  append(number.data(), 1, stream);
  append(number.data(), 2, nullptr);
  append(number.data(), 3, stream);
  EXPECT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
  EXPECT_EQ(number.read()[0], 123u);
}

TEST(Streams, WaitForEvents) {
  Buffer<Wide> number(std::vector<Wide>{0});
  const Stream a, b;
  cudaEvent_t event = nullptr;
  ASSERT_EQ(cudaEventCreate(&event), cudaSuccess);
  append(number.data(), 1, a);
  ASSERT_EQ(cudaEventRecord(event, a), cudaSuccess);
  ASSERT_EQ(cudaStreamWaitEvent(b, event), cudaSuccess);
  append(number.data(), 2, b);
  EXPECT_EQ(cudaStreamSynchronize(b), cudaSuccess);
  EXPECT_EQ(number.read()[0], 12u);
  EXPECT_EQ(cudaEventQuery(event), cudaSuccess);
  EXPECT_EQ(cudaEventDestroy(event), cudaSuccess);
  EXPECT_EQ(cudaEventDestroy(event), cudaErrorInvalidResourceHandle);
}

TEST(Events, MeasureTime) {
  Buffer<Wide> number(std::vector<Wide>{0});
  cudaEvent_t begin = nullptr, end = nullptr;
  cudaEventCreate(&begin);
  cudaEventCreate(&end);
  float milliseconds = -1.0f;
  EXPECT_EQ(cudaEventElapsedTime(&milliseconds, begin, end), cudaErrorInvalidResourceHandle);
  cudaEventRecord(begin);
  append(number.data(), 1, nullptr);
  cudaEventRecord(end);
  EXPECT_EQ(cudaEventElapsedTime(&milliseconds, begin, end), cudaErrorNotReady);
  EXPECT_EQ(cudaEventSynchronize(end), cudaSuccess);
  EXPECT_EQ(cudaEventElapsedTime(&milliseconds, begin, end), cudaSuccess);
  EXPECT_GT(milliseconds, 0.0f);
  cudaEventDestroy(begin);
  cudaEventDestroy(end);
}

TEST(Streams, DestroyedOnesAreNoneAnyMore) {
  cudaStream_t stream = nullptr;
  ASSERT_EQ(cudaStreamCreate(&stream), cudaSuccess);
  EXPECT_EQ(cudaStreamDestroy(stream), cudaSuccess);
  EXPECT_EQ(cudaStreamDestroy(stream), cudaErrorInvalidResourceHandle);
  EXPECT_EQ(cudaStreamSynchronize(stream), cudaErrorInvalidResourceHandle);
}

__global__ void multiply(unsigned* values, unsigned factor) { values[threadIdx.x] *= factor; }

TEST(Graphs, ReplayOnWhatMemoryHoldsThen) {
  Buffer<unsigned> values({1, 2, 3});
  const Stream stream;
  ASSERT_EQ(cudaStreamBeginCapture(stream, cudaStreamCaptureModeGlobal), cudaSuccess);
  unsigned factor = 5;
  cudaLaunchConfig_t config{1, 3, 0, stream, nullptr, 0};
  ASSERT_EQ(cudaLaunchKernelEx(&config, multiply, values.data(), factor), cudaSuccess);
  factor = 100;  // arguments were copied
  cudaGraph_t graph = nullptr;
  ASSERT_EQ(cudaStreamEndCapture(stream, &graph), cudaSuccess);
  EXPECT_EQ(values.read(), (std::vector<unsigned>{1, 2, 3})) << "capturing runs nothing";

  cudaGraphExec_t executable = nullptr;
  ASSERT_EQ(cudaGraphInstantiate(&executable, graph, 0), cudaSuccess);
  EXPECT_EQ(cudaGraphDestroy(graph), cudaSuccess);
  ASSERT_EQ(cudaGraphLaunch(executable, stream), cudaSuccess);
  ASSERT_EQ(cudaGraphLaunch(executable, stream), cudaSuccess);
  EXPECT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
  EXPECT_EQ(values.read(), (std::vector<unsigned>{25, 50, 75}));
  values.write({7, 8, 9});
  ASSERT_EQ(cudaGraphLaunch(executable, stream), cudaSuccess);
  EXPECT_EQ(cudaGraphExecDestroy(executable), cudaSuccess);
  EXPECT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
  EXPECT_EQ(values.read(), (std::vector<unsigned>{35, 40, 45}));
  EXPECT_EQ(cudaGraphLaunch(executable, stream), cudaErrorInvalidValue);
}

/// Captures on a stream while calling something that captures forbid.
template <class Call>
void expect_forbidden(Call&& call, cudaError_t expected) {
  const Stream stream(cudaStreamDefault);
  ASSERT_EQ(cudaStreamBeginCapture(stream, cudaStreamCaptureModeGlobal), cudaSuccess);
  EXPECT_EQ(call(cudaStream_t(stream)), expected);
  cudaStreamCaptureStatus status{};
  EXPECT_EQ(cudaStreamIsCapturing(stream, &status), cudaSuccess);
  EXPECT_EQ(status, cudaStreamCaptureStatusInvalidated);
  cudaGraph_t graph = nullptr;
  EXPECT_EQ(cudaStreamEndCapture(stream, &graph), cudaErrorStreamCaptureInvalidated);
  EXPECT_EQ(graph, nullptr);
}

TEST(Graphs, CapturesForbidCallsThatWaitOrAllocate) {
  Buffer<Wide> number(std::vector<Wide>{0});
  void* memory = nullptr;
  const auto unsupported = cudaErrorStreamCaptureUnsupported;
  expect_forbidden([](cudaStream_t s) { return cudaStreamSynchronize(s); }, unsupported);
  expect_forbidden([](cudaStream_t s) { return cudaStreamQuery(s); }, unsupported);
  expect_forbidden([](cudaStream_t) { return cudaDeviceSynchronize(); }, unsupported);
  expect_forbidden([&](cudaStream_t) { return cudaMalloc(&memory, 8); }, unsupported);
  expect_forbidden([&](cudaStream_t) { return append(number.data(), 1, nullptr); },
                   cudaErrorStreamCaptureImplicit);
}

TEST(Graphs, StreamsJoinACaptureThroughEvents) {
  Buffer<Wide> number(std::vector<Wide>{0});
  const Stream a, b;
  cudaEvent_t fork = nullptr, join = nullptr;
  cudaEventCreate(&fork);
  cudaEventCreate(&join);
  ASSERT_EQ(cudaStreamBeginCapture(a, cudaStreamCaptureModeThreadLocal), cudaSuccess);
  append(number.data(), 1, a);
  cudaEventRecord(fork, a);
  ASSERT_EQ(cudaStreamWaitEvent(b, fork), cudaSuccess);
  append(number.data(), 2, b);
  cudaEventRecord(join, b);
  ASSERT_EQ(cudaStreamWaitEvent(a, join), cudaSuccess);
  append(number.data(), 3, a);
  cudaGraph_t graph = nullptr;
  EXPECT_EQ(cudaStreamEndCapture(b, &graph), cudaErrorStreamCaptureUnmatched);
  ASSERT_EQ(cudaStreamEndCapture(a, &graph), cudaSuccess);
  cudaGraphExec_t executable = nullptr;
  ASSERT_EQ(cudaGraphInstantiate(&executable, graph), cudaSuccess);
  ASSERT_EQ(cudaGraphLaunch(executable, nullptr), cudaSuccess);
  EXPECT_EQ(cudaDeviceSynchronize(), cudaSuccess);
  EXPECT_EQ(number.read()[0], 123u);
  cudaGraphExecDestroy(executable);
  cudaGraphDestroy(graph);
  cudaEventDestroy(fork);
  cudaEventDestroy(join);
}

}  // namespace
}  // namespace treelet::emulator::test
