#include <treelet/core/arena.h>

#include <algorithm>
#include <bit>
#include <new>

#include <treelet/core/memory.h>

namespace treelet {
namespace {

/// The arena of the innermost scope on this thread, which keeps it alive.
thread_local Arena* current_arena = nullptr;

/// Up by an eighth at most, so that the next frame's array fits although it is a little longer.
std::size_t round_up_to_class(std::size_t bytes) {
  const std::size_t step = std::max<std::size_t>(std::bit_floor(bytes) / 8, 64);
  return (bytes + step - 1) / step * step;
}

}  // namespace

Arena::~Arena() { release_free(); }

void* Arena::lend(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  Block* block = find_free(bytes);
  if (block == nullptr) {
    blocks_.reserve(blocks_.size() + 1);
    const std::size_t size = round_up_to_class(bytes);
    if (size < bytes) throw std::bad_alloc();
    blocks_.push_back({allocate_bytes(size), size, false, false});
    block = &blocks_.back();
  }
  block->is_lent = block->was_lent = true;
  poison_bytes(block->memory, block->bytes);
  unpoison_bytes(block->memory, bytes);
  return block->memory;
}

void Arena::take_back(void* memory) noexcept {
  const std::lock_guard lock(mutex_);
  for (Block& block : blocks_) {
    if (block.memory != memory) continue;
    poison_bytes(block.memory, block.bytes);
    block.is_lent = false;
    return;
  }
}

void Arena::release_idle() noexcept {
  release_except([](const Block& block) { return block.was_lent; });
}
void Arena::release_free() noexcept {
  release_except([](const Block& block) { return block.is_lent; });
}

template <class IsKept>
void Arena::release_except(IsKept&& is_kept) noexcept {
  const std::lock_guard lock(mutex_);
  std::erase_if(blocks_, [&](const Block& block) {
    if (is_kept(block)) return false;
    unpoison_bytes(block.memory, block.bytes);
    free_bytes(block.memory);
    return true;
  });
  for (Block& block : blocks_) block.was_lent = block.is_lent;
}

std::size_t Arena::bytes() const {
  const std::lock_guard lock(mutex_);
  std::size_t total = 0;
  for (const Block& block : blocks_) total += block.bytes;
  return total;
}

Arena::Block* Arena::find_free(std::size_t bytes) {
  Block* best = nullptr;
  for (Block& block : blocks_) {
    const bool fits = !block.is_lent && block.bytes >= bytes && block.bytes / 2 <= bytes;
    if (fits && (best == nullptr || block.bytes < best->bytes)) best = &block;
  }
  return best;
}

ArenaScope::ArenaScope(std::shared_ptr<Arena> arena)
    : arena_(std::move(arena)), outer_(std::exchange(current_arena, arena_.get())) {}
ArenaScope::~ArenaScope() { current_arena = outer_; }

Allocation::Allocation(std::size_t bytes) {
  if (current_arena != nullptr) {
    home_ = current_arena->weak_from_this();
    memory_ = current_arena->lend(bytes);
  } else {
    memory_ = allocate_bytes(bytes);
  }
}

Allocation::~Allocation() {
  if (memory_ == nullptr || owner_ != nullptr) return;
  if (const std::shared_ptr<Arena> arena = home_.lock()) {
    arena->take_back(memory_);
  } else {
    free_bytes(memory_);
  }
}

}  // namespace treelet
