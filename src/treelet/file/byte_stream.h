#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <treelet/file/file_error.h>

namespace treelet {

/// Puts numbers and texts one after the other, without gaps.
class ByteWriter {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* const first = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), first, first + sizeof(T));
  }
  void put_text(const std::string& text) {
    put(std::uint32_t(text.size()));
    for (const char c : text) put(c);
  }
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

/// Takes them in the same order. Throws FileError beyond the end.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  void take(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(&value, next(sizeof(T)), sizeof(T));
  }
  template <class T>
  T take() {
    T value;
    take(value);
    return value;
  }
  /// Printable ASCII: all that recipes and names of stages are made of.
  std::string take_text() {
    const auto size = take<std::uint32_t>();
    const auto* const first = reinterpret_cast<const char*>(next(size));
    const auto is_printable = [](char c) { return c >= ' ' && c <= '~'; };
    if (!std::all_of(first, first + size, is_printable)) throw FileError("a text is unreadable");
    return {first, first + size};
  }
  /// How many items follow that take so many bytes each at least.
  std::size_t take_count(std::size_t item_bytes) {
    const auto count = take<std::uint64_t>();
    if (count > bytes_.size() / item_bytes) throw FileError("a list is longer than its section");
    return std::size_t(count);
  }
  bool is_at_end() const { return bytes_.empty(); }

 private:
  const std::byte* next(std::size_t size) {
    if (size > bytes_.size()) throw FileError("a section ends too early");
    const std::byte* const first = bytes_.data();
    bytes_ = bytes_.subspan(size);
    return first;
  }

  std::span<const std::byte> bytes_;
};

}  // namespace treelet
