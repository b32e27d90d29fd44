#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
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

using FlagArray =
    nanobind::ndarray<const bool, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;
using FaceNumbers = nanobind::ndarray<const std::int32_t, nanobind::ndim<1>, nanobind::c_contig,
                                      nanobind::device::cpu>;

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

/// Memory for answers: the caller's, a row of values that the Python layer has checked, or new.
template <class T>
class Answers {
 public:
  explicit Answers(std::size_t size, nanobind::handle given = nanobind::none()) : size_(size) {
    if (given.is_none()) {
      own_ = treelet::Array<T>(size);
      data_ = own_.data();
      return;
    }
    const auto array = nanobind::cast<GivenArray>(given, false);
    if (array.shape(0) != size) throw nanobind::value_error("no room for the answers");
    data_ = array.data();
    given_ = nanobind::borrow(given);
  }

  std::size_t size() const { return size_; }
  T* data() { return data_; }
  std::span<T> span() { return {data_, size_}; }
  T& operator[](std::size_t i) { return data_[i]; }

  /// To be asked for once.
  NumpyArray<T> to_numpy() {
    if (given_.is_valid()) return NumpyArray<T>(data_, {size_}, given_);
    return as_numpy(std::move(own_));
  }

 private:
  using GivenArray =
      nanobind::ndarray<T, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;

  std::size_t size_;
  treelet::Array<T> own_;
  T* data_;
  nanobind::object given_;
};

/// One of several arrays that the caller gave, or none.
inline nanobind::object part_of(nanobind::handle given, std::size_t i) {
  return given.is_none() ? nanobind::none() : nanobind::object(given[i]);
}
