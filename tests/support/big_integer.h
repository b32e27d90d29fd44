#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace treelet::test {

/// An integer of any size, by school arithmetic: slow, and simple enough to be trusted as the
/// oracle of exact predicates.
class BigInteger {
 public:
  BigInteger() = default;

  /// value * 2^shift, which must be an integer.
  static BigInteger from_scaled(double value, int shift) {
    BigInteger result;
    if (value == 0.0) return result;
    int exponent = 0;
    const double mantissa = std::frexp(std::fabs(value), &exponent);
    auto digits = std::uint64_t(std::ldexp(mantissa, 53));
    int zeros = exponent - 53 + shift;
    for (; zeros < 0 && digits % 2 == 0; ++zeros) digits /= 2;
    if (zeros < 0) throw zeros;
    result.negative_ = value < 0.0;
    result.limbs_.assign(std::size_t(zeros) / 32, 0);
    const std::uint64_t low = (digits & 0xffffffff) << zeros % 32;
    const std::uint64_t high = (digits >> 32 << zeros % 32) + (low >> 32);
    for (const std::uint64_t limb : {low, high, high >> 32}) {
      result.limbs_.push_back(std::uint32_t(limb));
    }
    result.trim();
    return result;
  }

  int sign() const { return limbs_.empty() ? 0 : negative_ ? -1 : 1; }
  BigInteger magnitude() const {
    BigInteger result = *this;
    result.negative_ = false;
    return result;
  }
  BigInteger operator-() const {
    BigInteger result = *this;
    result.negative_ = !negative_;
    return result;
  }

  friend BigInteger operator+(const BigInteger& a, const BigInteger& b) {
    if (a.negative_ == b.negative_) return add_magnitudes(a, b);
    return less_magnitude(a, b) ? subtract_magnitudes(b, a) : subtract_magnitudes(a, b);
  }
  friend BigInteger operator-(const BigInteger& a, const BigInteger& b) { return a + -b; }

  friend BigInteger operator*(const BigInteger& a, const BigInteger& b) {
    BigInteger product;
    product.limbs_.assign(a.limbs_.size() + b.limbs_.size(), 0);
    for (std::size_t i = 0; i < a.limbs_.size(); ++i) {
      std::uint64_t carry = 0;
      for (std::size_t j = 0; j < b.limbs_.size(); ++j) {
        carry += product.limbs_[i + j] + std::uint64_t(a.limbs_[i]) * b.limbs_[j];
        product.limbs_[i + j] = std::uint32_t(carry);
        carry >>= 32;
      }
      product.limbs_[i + b.limbs_.size()] = std::uint32_t(carry);
    }
    product.negative_ = a.negative_ != b.negative_;
    product.trim();
    return product;
  }

 private:
  static bool less_magnitude(const BigInteger& a, const BigInteger& b) {
    if (a.limbs_.size() != b.limbs_.size()) return a.limbs_.size() < b.limbs_.size();
    return std::lexicographical_compare(a.limbs_.rbegin(), a.limbs_.rend(), b.limbs_.rbegin(),
                                        b.limbs_.rend());
  }

  std::uint32_t limb(std::size_t i) const { return i < limbs_.size() ? limbs_[i] : 0; }

  static BigInteger add_magnitudes(const BigInteger& a, const BigInteger& b) {
    BigInteger sum;
    sum.negative_ = a.negative_;
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i <= std::max(a.limbs_.size(), b.limbs_.size()); ++i) {
      carry += std::uint64_t(a.limb(i)) + b.limb(i);
      sum.limbs_.push_back(std::uint32_t(carry));
      carry >>= 32;
    }
    sum.trim();
    return sum;
  }

  /// |a| - |b| with the sign of a; |a| >= |b|.
  static BigInteger subtract_magnitudes(const BigInteger& a, const BigInteger& b) {
    BigInteger difference;
    difference.negative_ = a.negative_;
    std::uint64_t borrow = 0;
    for (std::size_t i = 0; i < a.limbs_.size(); ++i) {
      const std::uint64_t limb = std::uint64_t(a.limb(i)) - b.limb(i) - borrow;
      difference.limbs_.push_back(std::uint32_t(limb));
      borrow = limb >> 63;
    }
    difference.trim();
    return difference;
  }

  void trim() {
    while (!limbs_.empty() && limbs_.back() == 0) limbs_.pop_back();
    if (limbs_.empty()) negative_ = false;
  }

  std::vector<std::uint32_t> limbs_;  // least significant first, no leading zeros
  bool negative_ = false;
};

}  // namespace treelet::test
