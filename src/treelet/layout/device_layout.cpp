#include <treelet/layout/device_layout.h>

namespace treelet::cuda {
namespace {

template <class Layout>
LayoutSummary download_summary(const Layout& bvh, Stream stream) {
  return treelet::cuda::download(bvh.summary, 1, stream)[0];
}

}  // namespace

Bvh2 download(const DeviceBvh2& bvh, Stream stream) {
  const LayoutSummary summary = download_summary(bvh, stream);
  return {download(bvh.nodes, summary.size.nodes, stream),
          download(bvh.items, summary.size.items, stream), summary.bounds, summary.size.depth};
}

Bvh8 download(const DeviceBvh8& bvh, Stream stream) {
  const LayoutSummary summary = download_summary(bvh, stream);
  return {download(bvh.nodes, summary.size.nodes, stream),
          download(bvh.items, summary.size.items, stream), summary.bounds, summary.size.depth,
          summary.size.triangles};
}

Cwbvh download(const DeviceCwbvh& bvh, Stream stream) {
  const LayoutSummary summary = download_summary(bvh, stream);
  return {download(bvh.nodes, summary.size.nodes, stream),
          download(bvh.items, summary.size.items, stream), summary.bounds, summary.size.depth};
}

}  // namespace treelet::cuda
