#pragma once

#include <cstddef>
#include <iterator>

// Stands in for Thrust's header of the same name.

namespace thrust {

/// Points at value, value + 1, ...
template <class T>
class counting_iterator {
 public:
  using value_type = T;
  using difference_type = std::ptrdiff_t;
  using pointer = const T*;
  using reference = T;
  using iterator_category = std::random_access_iterator_tag;

  counting_iterator() = default;
  explicit counting_iterator(T value) : value_(value) {}

  T operator*() const { return value_; }
  T operator[](difference_type i) const { return T(value_ + T(i)); }
  counting_iterator& operator++() {
    ++value_;
    return *this;
  }
  counting_iterator operator+(difference_type i) const {
    return counting_iterator(T(value_ + T(i)));
  }
  difference_type operator-(const counting_iterator& other) const {
    return difference_type(value_) - difference_type(other.value_);
  }
  bool operator==(const counting_iterator& other) const = default;

 private:
  T value_{};
};

template <class T>
counting_iterator<T> make_counting_iterator(T value) {
  return counting_iterator<T>(value);
}

}  // namespace thrust
