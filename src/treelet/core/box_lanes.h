#pragma once

#include <bit>
#include <cstdint>
#include <limits>

#include <treelet/core/aabb.h>

namespace treelet {

/// A box in two registers, x, y and z side by side; the fourth lanes are its user's. Gives what
/// Aabb gives, bit for bit.
struct BoxLanes {
  using Floats = float __attribute__((vector_size(16)));
  using Ints = std::int32_t __attribute__((vector_size(16)));

  Floats lower, upper;

  static BoxLanes empty() {
    constexpr Floats kInfinity = Floats{} + std::numeric_limits<float>::infinity();
    return {kInfinity, -kInfinity};
  }
  /// Of a box that lies in memory as two times four values, such as a node or a reference.
  template <class T>
  static BoxLanes load_box(const T& item) {
    static_assert(sizeof(T) == sizeof(BoxLanes) && alignof(T) >= 16);
    return std::bit_cast<BoxLanes>(item);
  }
  static Floats load(Vec3 p) { return Floats{p.x, p.y, p.z, 0.0f}; }
  /// The fourth lane holds the bits of a number.
  static Floats with_number(Floats lanes, std::uint32_t number) {
    Ints bits = std::bit_cast<Ints>(lanes);
    bits[3] = std::int32_t(number);
    return std::bit_cast<Floats>(bits);
  }
  static std::uint32_t number(Floats lanes) { return std::uint32_t(std::bit_cast<Ints>(lanes)[3]); }

  static Floats min(Floats a, Floats b) { return b < a ? b : a; }
  static Floats max(Floats a, Floats b) { return a < b ? b : a; }

  float half_area() const {
    const Floats d = upper - lower;
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
  }
  /// Twice the centroid (primitive/reference.h).
  Floats doubled_centroid() const { return lower + upper; }
  void add(const BoxLanes& box) { *this = merge(*this, box); }
  void add_point(Floats point) { add({point, point}); }
  Aabb box() const { return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}}; }

  friend BoxLanes merge(const BoxLanes& a, const BoxLanes& b) {
    return {min(a.lower, b.lower), max(a.upper, b.upper)};
  }
};

}  // namespace treelet
