#pragma once

#include <memory>
#include <mutex>
#include <optional>

#include <treelet/query/winding_moments.h>

namespace treelet {

/// What some queries need of a tree, made when it is first asked for, by one thread while others
/// wait.
template <class Made>
class Lazy {
 public:
  template <class Layout>
  const Made& of(const Layout& bvh) const {
    const std::lock_guard lock(kept_->mutex);
    if (!kept_->made) kept_->made.emplace(bvh);
    return *kept_->made;
  }

  /// For a tree that has changed; no query may run meanwhile.
  void forget() { kept_->made.reset(); }

 private:
  struct Kept {
    std::mutex mutex;
    std::optional<Made> made;
  };
  std::unique_ptr<Kept> kept_ = std::make_unique<Kept>();
};

using LazyMoments = Lazy<WindingMoments>;

}  // namespace treelet
