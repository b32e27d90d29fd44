#include <treelet/pipeline/device_bvh.h>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/core/cuda_check.cuh>

#include <string>
#include <vector>

#include "cuda/device_input.h"
#include "support/layouts.h"
#include "support/meshes.h"

// A rebuild waits for nothing and allocates nothing, so a CUDA graph can record it once and replay
// it over vertices that have moved meanwhile.

namespace treelet {
namespace {

class RebuildGraph : public testing::TestWithParam<std::string> {
 protected:
  RebuildGraph() {
    cuda::check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "create a stream");
  }
  ~RebuildGraph() override { cudaStreamDestroy(stream_); }

  /// Records what body enqueues.
  template <class Body>
  cudaGraphExec_t record(Body&& body) {
    cuda::check(cudaStreamBeginCapture(stream_, cudaStreamCaptureModeThreadLocal), "record");
    body();
    cudaGraph_t graph = nullptr;
    cuda::check(cudaStreamEndCapture(stream_, &graph), "end the recording");
    cudaGraphExec_t executable = nullptr;
    cuda::check(cudaGraphInstantiate(&executable, graph, 0), "make a graph");
    cudaGraphDestroy(graph);
    return executable;
  }

  cudaStream_t stream_ = nullptr;
};

TEST_P(RebuildGraph, ReplaysOverMovedVertices) {
  const test::OwnedMesh mesh = test::triangle_soup(5000, 21);
  const cuda::DeviceArray<Face> faces = test::upload_all(std::span(mesh.faces));
  cuda::DeviceArray<Vec3> vertices = test::upload_all(std::span(mesh.vertices));
  const auto count = std::uint32_t(vertices.size());
  const cuda::DeviceMesh view{vertices.data(), faces.data(), count, std::uint32_t(faces.size())};
  cuda::DeviceBvh bvh = cuda::DeviceBvh::build(view, parse_recipe(GetParam()),
                                               {.validate = false, .updatable = true}, stream_);
  const cudaGraphExec_t graph = record([&] { bvh.rebuild(vertices.data(), count, stream_); });
  for (const float factor : {0.5f, 0.8f}) {
    test::OwnedMesh moved = mesh;
    for (Vec3& p : moved.vertices) p.x = p.x * p.x * factor;
    cuda::copy_to_device(vertices.data(), moved.vertices.data(), vertices.bytes(), stream_);
    cuda::check(cudaGraphLaunch(graph, stream_), "launch a graph");
    bvh.check(stream_);
    const Bvh device = bvh.download(stream_), host = build(moved.view(), GetParam());
    EXPECT_TRUE(test::equal_bytes(device, host));
  }
  cudaGraphExecDestroy(graph);
}

/// Names a test after the last word of its recipe.
std::string layout_name(const testing::TestParamInfo<std::string>& parameter) {
  return parameter.param.substr(parameter.param.rfind(' ') + 1);
}

INSTANTIATE_TEST_SUITE_P(Recipes, RebuildGraph,
                         testing::Values("lbvh > treelet > bvh2", "lbvh > bvh8", "lbvh > cwbvh"),
                         layout_name);

}  // namespace
}  // namespace treelet
