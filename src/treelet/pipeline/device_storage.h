#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <variant>

#include <treelet/core/carver.h>
#include <treelet/core/device_array.h>
#include <treelet/layout/device_layout.h>
#include <treelet/layout/device_refit_layout.h>
#include <treelet/pipeline/device_build.h>
#include <treelet/pipeline/recipe.h>
#include <treelet/primitive/device_references.h>

// What a DeviceBvh owns in device memory.

namespace treelet::cuda {

using Storage = std::variant<Bvh2Storage, Bvh8Storage, CwbvhStorage>;

/// The links that refits of a layout need (layout/device_refit_layout.h).
class LinkMemory {
 public:
  LinkMemory(const Storage& layout, std::uint32_t node_capacity, Stream stream)
      : bytes_(node_capacity * link_size(layout), stream) {}

  template <class Layout>
  LinkOf<Layout>* of(const Layout&) {
    return reinterpret_cast<LinkOf<Layout>*>(bytes_.data());
  }
  std::size_t bytes() const { return bytes_.bytes(); }
  void free_on(Stream stream) { bytes_.free_on(stream); }

 private:
  template <class Layout>
  static constexpr std::size_t size_of(const LayoutStorage<Layout>&) {
    return sizeof(LinkOf<Layout>);
  }
  static std::size_t link_size(const Storage& layout) {
    return std::visit([](const auto& stored) { return size_of(stored); }, layout);
  }

  DeviceArray<std::byte> bytes_;
};

/// Memory of a build that carves itself.
class Workspace {
 public:
  Workspace(std::uint32_t faces, const Recipe& recipe, Stream stream) {
    Carver counting;
    carve_build(counting, faces, recipe);
    block_ = DeviceArray<std::byte>(counting.peak(), stream);
    Carver carver(block_.data());
    memory_ = carve_build(carver, faces, recipe);
  }

  const BuildMemory& memory() const { return memory_; }
  std::size_t bytes() const { return block_.bytes(); }
  void free_on(Stream stream) { block_.free_on(stream); }

 private:
  DeviceArray<std::byte> block_;
  BuildMemory memory_;
};

/// What a tree keeps to be updated.
struct UpdateMemory {
  Recipe recipe;
  DeviceArray<Face> faces;
  std::uint32_t vertex_count;
  Workspace workspace;
  LinkMemory links;

  DeviceMesh mesh(const Vec3* vertices) const {
    return {vertices, faces.data(), vertex_count, std::uint32_t(faces.size())};
  }
  std::size_t bytes() const { return faces.bytes() + workspace.bytes() + links.bytes(); }
  void free_on(Stream stream) {
    faces.free_on(stream);
    workspace.free_on(stream);
    links.free_on(stream);
  }
};

inline void free_on(Storage& storage, Stream stream) {
  std::visit([&](auto& stored) { stored.free_on(stream); }, storage);
}

inline Storage allocate(const Recipe& recipe, std::uint32_t nodes, std::uint32_t items,
                        Stream stream) {
  if (recipe.layout.word->name == "bvh2") return Bvh2Storage(nodes, items, stream);
  if (recipe.layout.word->name == "bvh8") return Bvh8Storage(nodes, items, stream);
  return CwbvhStorage(nodes, items, stream);
}

inline const Array<PackedTriangle>& items_of(const Bvh2& bvh) { return bvh.triangles; }
inline const Array<TriangleBlock>& items_of(const Bvh8& bvh) { return bvh.blocks; }
inline const Array<CwbvhTriangle>& items_of(const Cwbvh& bvh) { return bvh.triangles; }
inline std::size_t triangle_count(const Bvh2& bvh) { return bvh.triangles.size(); }
inline std::size_t triangle_count(const Bvh8& bvh) { return bvh.triangle_count; }
inline std::size_t triangle_count(const Cwbvh& bvh) { return bvh.triangles.size(); }

template <class Stored, class Layout>
Storage upload_layout(const Layout& bvh, Stream stream) {
  const auto& items = items_of(bvh);
  const std::uint32_t nodes = std::uint32_t(bvh.nodes.size());
  const LayoutSummary summary{
      bvh.bounds,
      {nodes, std::uint32_t(items.size()), std::uint32_t(triangle_count(bvh)), bvh.depth},
      0,
      0};
  Stored stored(nodes, std::uint32_t(items.size()), stream);
  copy_to_device(stored.view().nodes, bvh.nodes.data(), bvh.nodes.bytes(), stream);
  copy_to_device(stored.view().items, items.data(), items.bytes(), stream);
  copy_to_device(stored.view().summary, &summary, sizeof(summary), stream);
  synchronize(stream);
  return stored;
}
inline Storage upload_any(const Bvh2& bvh, Stream stream) {
  return upload_layout<Bvh2Storage>(bvh, stream);
}
inline Storage upload_any(const Bvh8& bvh, Stream stream) {
  return upload_layout<Bvh8Storage>(bvh, stream);
}
inline Storage upload_any(const Cwbvh& bvh, Stream stream) {
  return upload_layout<CwbvhStorage>(bvh, stream);
}

}  // namespace treelet::cuda
