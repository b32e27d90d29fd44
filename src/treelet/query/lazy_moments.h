#pragma once

#include <memory>
#include <mutex>
#include <optional>

#include <treelet/query/winding_moments.h>

namespace treelet {

/// What winding numbers need of a tree, made when it is first asked for, by one thread while others
/// wait.
class LazyMoments {
 public:
  template <class Layout>
  const WindingMoments& of(const Layout& bvh) const {
    const std::lock_guard lock(kept_->mutex);
    if (!kept_->moments) kept_->moments.emplace(bvh);
    return *kept_->moments;
  }

  /// For a tree that has changed; no query may run meanwhile.
  void forget() { kept_->moments.reset(); }

 private:
  struct Kept {
    std::mutex mutex;
    std::optional<WindingMoments> moments;
  };
  std::unique_ptr<Kept> kept_ = std::make_unique<Kept>();
};

}  // namespace treelet
