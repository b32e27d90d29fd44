#include <treelet/layout/device_layout.h>

namespace treelet::cuda {
namespace {

/// What all layouts begin with, and what one may have besides.
template <class Host, class Layout>
Host download_layout(const Layout& bvh, Stream stream) {
  const LayoutSummary summary = download(bvh.summary, 1, stream)[0];
  const LayoutSize& size = summary.size;
  Host host{download(bvh.nodes, size.nodes, stream), download(bvh.items, size.items, stream),
            summary.bounds, size.depth};
  if constexpr (requires { host.triangle_count; }) host.triangle_count = size.triangles;
  return host;
}

}  // namespace

Bvh2 download(const DeviceBvh2& bvh, Stream stream) { return download_layout<Bvh2>(bvh, stream); }
Bvh8 download(const DeviceBvh8& bvh, Stream stream) { return download_layout<Bvh8>(bvh, stream); }
Cwbvh download(const DeviceCwbvh& bvh, Stream stream) {
  return download_layout<Cwbvh>(bvh, stream);
}

}  // namespace treelet::cuda
