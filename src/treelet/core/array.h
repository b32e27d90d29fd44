#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

#include <treelet/core/arena.h>

namespace treelet {

/// Owns `size` values on a cache-line boundary, uninitialised at first: every array here is written
/// by the stage that makes it, and clearing it before would cost as much as the stage. Memory comes
/// from the arena of the thread that makes it, if any (core/arena.h). An array may also borrow
/// values, of a mapped file for one; it must not be written to then.
template <class T>
class Array {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  Array() = default;
  explicit Array(std::size_t size)
      : allocation_(size == 0 ? Allocation() : Allocation(size * sizeof(T))), size_(size) {}
  Array(std::size_t size, const T& value) : Array(size) { std::fill(begin(), end(), value); }
  Array(Array&& other) noexcept
      : allocation_(std::move(other.allocation_)), size_(std::exchange(other.size_, 0)) {}
  /// `owner` keeps the values alive for as long as the array does.
  static Array borrow(std::span<const T> values, std::shared_ptr<const void> owner) {
    Array array;
    array.allocation_ = Allocation(values.data(), std::move(owner));
    array.size_ = values.size();
    return array;
  }
  Array& operator=(Array&& other) noexcept {
    allocation_ = std::move(other.allocation_);  // swaps
    std::swap(size_, other.size_);
    return *this;
  }

  Array clone() const {
    Array copy(size_);
    std::copy(begin(), end(), copy.begin());
    return copy;
  }

  std::size_t size() const { return size_; }
  std::size_t bytes() const { return size_ * sizeof(T); }
  bool empty() const { return size_ == 0; }
  T* data() { return static_cast<T*>(allocation_.memory()); }
  const T* data() const { return static_cast<const T*>(allocation_.memory()); }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  operator std::span<T>() { return {data(), size_}; }
  operator std::span<const T>() const { return {data(), size_}; }

 private:
  Allocation allocation_;
  std::size_t size_ = 0;
};

}  // namespace treelet
