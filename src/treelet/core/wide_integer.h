#pragma once

#include <cstdint>

namespace treelet {

/// An integer as large as a product of three differences of doubles, whatever their magnitudes:
/// 2^-1074 to 2^1024 are 2098 bits. Slow (a microsecond for what doubles usually need): used where
/// a filter in doubles cannot decide. Differs from [Shewchuk1997], whose expansions are sums of
/// doubles and so would overflow and underflow here.
class WideInteger {
 public:
  WideInteger() = default;  ///< zero
  /// value / 2^exponent, which must be whole; the value finite.
  WideInteger(double value, int exponent);
  WideInteger(const WideInteger& other) { *this = other; }
  WideInteger& operator=(const WideInteger& other);

  int sign() const { return size_ == 0 ? 0 : is_negative_ ? -1 : 1; }
  WideInteger operator-() const;
  friend WideInteger operator+(const WideInteger& a, const WideInteger& b);
  friend WideInteger operator-(const WideInteger& a, const WideInteger& b) { return a + -b; }
  friend WideInteger operator*(const WideInteger& a, const WideInteger& b);

  /// numerator / denominator * 2^exponent, rounded to nearest; but never to zero unless it is, and
  /// twice where it is denormal. Infinite beyond the largest double.
  friend double quotient(const WideInteger& numerator, const WideInteger& denominator,
                         int exponent);

 private:
  static constexpr int kCapacity = 208;  // three times 66 for a product, and two for a quotient

  int bit_length() const;
  void shift_left(int bits);
  void trim();
  static int compare_magnitudes(const WideInteger& a, const WideInteger& b);
  void add_magnitude(const WideInteger& other);
  void subtract_magnitude(const WideInteger& smaller);

  int size_ = 0;
  bool is_negative_ = false;
  std::uint32_t limbs_[kCapacity];  ///< the least significant first
};

/// The largest k such that the value is a multiple of 2^k; a large number for zero.
int lowest_bit(double value);

}  // namespace treelet
