#include <treelet/traverse/hit_sink.h>

#include <algorithm>
#include <utility>

namespace treelet {

template <class Record>
void HitSink<Record>::grow() {
  constexpr std::size_t kFirst = 4096;
  const auto size = std::size_t(end_ - begin_);
  const std::size_t larger = std::max(kFirst, 2 * size);
  std::unique_ptr<Record[]> memory(new Record[larger]);  // uninitialised
  std::copy_n(begin_, size, memory.get());
  memory_ = std::move(memory);
  begin_ = memory_.get();
  next_ = begin_ + size;
  end_ = begin_ + larger;
}

template class HitSink<RayHit>;
template class HitSink<RayFace>;

}  // namespace treelet
