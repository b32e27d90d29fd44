#include <treelet/core/wide_integer.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace treelet {
namespace {

constexpr int kLimbBits = 32;
constexpr int kDigits = 53;

/// A double other than zero as digits * 2^exponent.
struct Digits {
  std::uint64_t digits;
  int exponent;

  explicit Digits(double value) {
    const double mantissa = std::frexp(std::fabs(value), &exponent);
    digits = std::uint64_t(std::ldexp(mantissa, kDigits));
    exponent -= kDigits;
    const int zeros = std::countr_zero(digits);
    digits >>= zeros;
    exponent += zeros;
  }
};

}  // namespace

int lowest_bit(double value) {
  return value == 0.0 ? std::numeric_limits<int>::max() : Digits(value).exponent;
}

WideInteger::WideInteger(double value, int exponent) {
  if (value == 0.0) return;
  const Digits parts(value);
  limbs_[0] = std::uint32_t(parts.digits);
  limbs_[1] = std::uint32_t(parts.digits >> kLimbBits);
  size_ = 2;
  is_negative_ = value < 0.0;
  trim();
  shift_left(parts.exponent - exponent);
}

WideInteger& WideInteger::operator=(const WideInteger& other) {
  size_ = other.size_;
  is_negative_ = other.is_negative_;
  std::copy_n(other.limbs_, size_, limbs_);
  return *this;
}

WideInteger WideInteger::operator-() const {
  WideInteger result = *this;
  result.is_negative_ = !is_negative_;
  return result;
}

WideInteger operator+(const WideInteger& a, const WideInteger& b) {
  const bool is_a_larger = WideInteger::compare_magnitudes(a, b) >= 0;
  WideInteger result = is_a_larger ? a : b;
  const WideInteger& other = is_a_larger ? b : a;
  if (a.is_negative_ == b.is_negative_) {
    result.add_magnitude(other);
  } else {
    result.subtract_magnitude(other);
  }
  return result;
}

WideInteger operator*(const WideInteger& a, const WideInteger& b) {
  WideInteger product;
  if (a.size_ == 0 || b.size_ == 0) return product;
  product.size_ = a.size_ + b.size_;
  product.is_negative_ = a.is_negative_ != b.is_negative_;
  std::fill_n(product.limbs_, product.size_, 0u);
  for (int i = 0; i < a.size_; ++i) {
    std::uint64_t carry = 0;
    for (int j = 0; j < b.size_; ++j) {
      carry += product.limbs_[i + j] + std::uint64_t(a.limbs_[i]) * b.limbs_[j];
      product.limbs_[i + j] = std::uint32_t(carry);
      carry >>= kLimbBits;
    }
    product.limbs_[i + b.size_] = std::uint32_t(carry);
  }
  product.trim();
  return product;
}

double quotient(const WideInteger& numerator, const WideInteger& denominator, int exponent) {
  if (numerator.size_ == 0) return 0.0;
  constexpr int kBits = kDigits + 3;
  WideInteger rest = numerator, divisor = denominator;
  rest.is_negative_ = divisor.is_negative_ = false;
  // Between a half and two; long division finds its bits one by one.
  const int common = divisor.bit_length() - rest.bit_length();
  if (common > 0) rest.shift_left(common);
  if (common < 0) divisor.shift_left(-common);
  std::uint64_t digits = 0;
  for (int i = 0; i < kBits; ++i) {
    digits <<= 1;
    if (WideInteger::compare_magnitudes(rest, divisor) >= 0) {
      rest.subtract_magnitude(divisor);
      digits |= 1;
    }
    rest.shift_left(1);
  }
  if (rest.size_ != 0) digits |= 1;  // odd: then rounding to 53 bits sees that it is no tie
  const double magnitude = std::ldexp(double(digits), exponent - common - kBits + 1);
  const double result = magnitude > 0.0 ? magnitude : std::numeric_limits<double>::denorm_min();
  return numerator.is_negative_ != denominator.is_negative_ ? -result : result;
}

int WideInteger::bit_length() const {
  return size_ == 0 ? 0 : size_ * kLimbBits - std::countl_zero(limbs_[size_ - 1]);
}

void WideInteger::shift_left(int bits) {
  if (size_ == 0 || bits == 0) return;
  const int limbs = bits / kLimbBits, rest = bits % kLimbBits;
  limbs_[size_ + limbs] = 0;
  for (int i = size_; i-- > 0;) {
    const std::uint64_t moved = std::uint64_t(limbs_[i]) << rest;
    limbs_[i + limbs + 1] |= std::uint32_t(moved >> kLimbBits);
    limbs_[i + limbs] = std::uint32_t(moved);
  }
  std::fill_n(limbs_, limbs, 0u);
  size_ += limbs + 1;
  trim();
}

void WideInteger::trim() {
  while (size_ != 0 && limbs_[size_ - 1] == 0) --size_;
  if (size_ == 0) is_negative_ = false;
}

int WideInteger::compare_magnitudes(const WideInteger& a, const WideInteger& b) {
  if (a.size_ != b.size_) return a.size_ < b.size_ ? -1 : 1;
  for (int i = a.size_; i-- > 0;) {
    if (a.limbs_[i] != b.limbs_[i]) return a.limbs_[i] < b.limbs_[i] ? -1 : 1;
  }
  return 0;
}

void WideInteger::add_magnitude(const WideInteger& other) {
  std::uint64_t carry = 0;
  for (int i = 0; i < size_; ++i) {
    carry += std::uint64_t(limbs_[i]) + (i < other.size_ ? other.limbs_[i] : 0);
    limbs_[i] = std::uint32_t(carry);
    carry >>= kLimbBits;
  }
  if (carry != 0) limbs_[size_++] = std::uint32_t(carry);
}

void WideInteger::subtract_magnitude(const WideInteger& smaller) {
  std::uint64_t borrow = 0;
  for (int i = 0; i < size_; ++i) {
    const std::uint64_t limb =
        std::uint64_t(limbs_[i]) - (i < smaller.size_ ? smaller.limbs_[i] : 0) - borrow;
    limbs_[i] = std::uint32_t(limb);
    borrow = limb >> 63;
  }
  trim();
}

}  // namespace treelet
