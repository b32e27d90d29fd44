#pragma once

#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>

#include <treelet/core/array.h>
#include <treelet/core/device_memory.h>

namespace treelet::cuda {

/// Owns `size` values in device memory, uninitialised at first. Allocates and frees in the order of
/// its stream, which must outlive it.
template <class T>
class DeviceArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  DeviceArray() = default;
  DeviceArray(std::size_t size, Stream stream)
      : data_(static_cast<T*>(allocate_device_bytes(size * sizeof(T), stream))),
        size_(size),
        stream_(stream) {}
  DeviceArray(DeviceArray&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)),
        stream_(other.stream_) {}
  DeviceArray& operator=(DeviceArray&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(stream_, other.stream_);
    return *this;
  }
  ~DeviceArray() { free_device_bytes(data_, stream_); }

  std::size_t size() const { return size_; }
  std::size_t bytes() const { return size_ * sizeof(T); }
  bool empty() const { return size_ == 0; }
  T* data() { return data_; }
  const T* data() const { return data_; }
  Stream stream() const { return stream_; }
  /// Frees on another stream, which the caller has ordered behind all uses.
  void free_on(Stream stream) { stream_ = stream; }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
  Stream stream_ = nullptr;
};

/// The source must stay until the stream has come past the copy.
template <class T>
DeviceArray<T> upload(std::span<const T> values, Stream stream) {
  DeviceArray<T> array(values.size(), stream);
  if (!values.empty()) copy_to_device(array.data(), values.data(), array.bytes(), stream);
  return array;
}

/// Waits for the copy.
template <class T>
Array<T> download(const T* values, std::size_t size, Stream stream) {
  Array<T> array(size);
  if (size > 0) copy_to_host(array.data(), values, size * sizeof(T), stream);
  return array;
}
template <class T>
Array<T> download(const DeviceArray<T>& values) {
  return download(values.data(), values.size(), values.stream());
}

}  // namespace treelet::cuda
