#pragma once

#include <cstdint>
#include <utility>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <treelet/core/array.h>
#include <treelet/core/vec.h>
#include <treelet/mesh/mesh.h>

/// Arrays as the Python layer passes them: it has converted and checked them, so that a call here
/// never copies.
using Vec3Array = nanobind::ndarray<const float, nanobind::shape<-1, 3>, nanobind::c_contig,
                                    nanobind::device::cpu>;
using FaceArray = nanobind::ndarray<const std::uint32_t, nanobind::shape<-1, 3>, nanobind::c_contig,
                                    nanobind::device::cpu>;
using FloatArray =
    nanobind::ndarray<const float, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;

template <class T>
using NumpyArray = nanobind::ndarray<nanobind::numpy, T>;

inline treelet::Mesh as_mesh(const Vec3Array& vertices, const FaceArray& faces) {
  return {{reinterpret_cast<const treelet::Vec3*>(vertices.data()), vertices.shape(0)},
          {reinterpret_cast<const treelet::Face*>(faces.data()), faces.shape(0)}};
}

/// Hands an array's memory to numpy without a copy.
template <class T>
NumpyArray<T> as_numpy(treelet::Array<T>&& array) {
  auto* kept = new treelet::Array<T>(std::move(array));
  nanobind::capsule owner(kept,
                          [](void* p) noexcept { delete static_cast<treelet::Array<T>*>(p); });
  const std::size_t size = kept->size();
  return NumpyArray<T>(kept->data(), {size}, owner);
}
