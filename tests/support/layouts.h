#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstring>
#include <string>
#include <type_traits>
#include <variant>

#include <treelet/core/array.h>
#include <treelet/pipeline/bvh.h>

namespace treelet::test {

/// Index of the first value whose bytes differ; the size where none does.
template <class T>
std::size_t first_difference(const Array<T>& a, const Array<T>& b) {
  std::size_t i = 0;
  while (i < a.size() && std::memcmp(&a[i], &b[i], sizeof(T)) == 0) ++i;
  return i;
}

/// Equality of every byte; else the message names the first value that differs.
template <class T>
testing::AssertionResult equal_bytes(const Array<T>& a, const Array<T>& b, const char* what) {
  if (a.size() != b.size()) {
    return testing::AssertionFailure() << a.size() << " " << what << "s, expected " << b.size();
  }
  const std::size_t i = first_difference(a, b);
  if (i == a.size()) return testing::AssertionSuccess();
  return testing::AssertionFailure() << what << " " << i << " differs";
}

/// A layout's triangles, in the form in which it holds them.
template <class Layout>
const auto& items(const Layout& layout) {
  if constexpr (requires { layout.blocks; }) {
    return layout.blocks;
  } else {
    return layout.triangles;
  }
}

template <class Layout>
std::size_t triangle_count(const Layout& layout) {
  if constexpr (requires { layout.triangle_count; }) {
    return layout.triangle_count;
  } else {
    return layout.triangles.size();
  }
}

/// Equality of every byte; else the message says what differs first.
template <class Layout>
testing::AssertionResult equal_bytes(const Layout& a, const Layout& b) {
  if (const auto nodes = equal_bytes(a.nodes, b.nodes, "node"); !nodes) return nodes;
  if (const auto same = equal_bytes(items(a), items(b), "item"); !same) return same;
  if (std::memcmp(&a.bounds, &b.bounds, sizeof(Aabb)) != 0) {
    return testing::AssertionFailure() << "bounds differ";
  }
  if (a.depth != b.depth || triangle_count(a) != triangle_count(b)) {
    return testing::AssertionFailure() << "depth or number of triangles differ";
  }
  return testing::AssertionSuccess();
}

/// The same for the layouts of two trees, which must be of one kind.
inline testing::AssertionResult equal_bytes(const Bvh& a, const Bvh& b) {
  return std::visit(
      [&](const auto& layout) {
        const auto* other = std::get_if<std::decay_t<decltype(layout)>>(&b.layout);
        if (other != nullptr) return equal_bytes(layout, *other);
        return testing::AssertionFailure() << "the layouts are of two kinds";
      },
      a.layout);
}

}  // namespace treelet::test
