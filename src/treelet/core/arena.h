#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace treelet {

/// Keeps the memory of arrays that are gone for arrays to come: fresh pages cost a build more than
/// most of its stages, for the kernel clears each. Arrays may be made and dropped by many threads,
/// and may outlive the arena: what is still lent when it ends belongs to its array. Not to be used
/// by the child of a fork() that came in the middle of a call.
class Arena : public std::enable_shared_from_this<Arena> {
 public:
  Arena() = default;
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// The smallest kept block that fits and is not half empty, else a new one. Throws
  /// std::bad_alloc.
  void* lend(std::size_t bytes);
  void take_back(void* memory) noexcept;

  /// Gives back to the system what has lain idle since the last call of any release.
  void release_idle() noexcept;
  /// Gives back all that is not lent.
  void release_free() noexcept;

  /// All blocks, lent or not.
  std::size_t bytes() const;

 private:
  struct Block {
    void* memory;
    std::size_t bytes;
    bool is_lent;
    bool was_lent;  ///< since the last release
  };

  Block* find_free(std::size_t bytes);
  template <class IsKept>
  void release_except(IsKept&& is_kept) noexcept;

  mutable std::mutex mutex_;
  std::vector<Block> blocks_;  // a build has some tens: searched one by one
};

/// Lets the arrays that this thread makes take their memory from an arena, or from the system where
/// that is null. Scopes may nest; the innermost one counts. Other threads are not affected, not
/// even those that help with this one's loops.
class ArenaScope {
 public:
  explicit ArenaScope(std::shared_ptr<Arena> arena);
  ~ArenaScope();
  ArenaScope(const ArenaScope&) = delete;
  ArenaScope& operator=(const ArenaScope&) = delete;

 private:
  std::shared_ptr<Arena> arena_;
  Arena* outer_;
};

/// Memory that goes back where it came from: to its arena, or to the system where there is none.
/// Or memory of somebody else's, to be read only, whose owner it keeps alive.
class Allocation {
 public:
  Allocation() = default;
  /// Throws std::bad_alloc.
  explicit Allocation(std::size_t bytes);
  Allocation(const void* borrowed, std::shared_ptr<const void> owner)
      : memory_(const_cast<void*>(borrowed)), owner_(std::move(owner)) {}
  Allocation(Allocation&& other) noexcept
      : memory_(std::exchange(other.memory_, nullptr)),
        home_(std::move(other.home_)),
        owner_(std::move(other.owner_)) {}
  Allocation& operator=(Allocation&& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(home_, other.home_);
    std::swap(owner_, other.owner_);
    return *this;
  }
  ~Allocation();

  void* memory() const { return memory_; }

 private:
  void* memory_ = nullptr;
  std::weak_ptr<Arena> home_;
  std::shared_ptr<const void> owner_;  // null: the memory is this one's own
};

}  // namespace treelet
