#include <treelet/primitive/device_sort.h>

#include <utility>

#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include <treelet/core/device_memory.h>
#include <treelet/core/cuda_check.cuh>

// CUB stands in this file alone: it takes longer to compile than all other kernels.

namespace treelet::cuda {
namespace {

template <class Key>
using Keys = cub::DoubleBuffer<Key>;
using Values = cub::DoubleBuffer<std::uint32_t>;

/// Without memory it only sets `bytes`.
template <class Key>
void sort_in_buffers(void* temporary, std::size_t& bytes, Keys<Key>& keys, Values& values,
                     std::uint32_t count, Stream stream) {
  constexpr int kKeyBits = 8 * sizeof(Key);
  check(cub::DeviceRadixSort::SortPairs(temporary, bytes, keys, values, count, 0, kKeyBits, stream),
        "sort on the device");
}

/// Without memory it only sets `bytes`.
template <class Value, class Count>
void sum_in_memory(void* temporary, std::size_t& bytes, const Value* values, Value* sums,
                   Count count, Stream stream) {
  check(cub::DeviceScan::ExclusiveSum(temporary, bytes, values, sums, count, stream),
        "sum on the device");
}

}  // namespace

SortScratch carve_sort_scratch(Carver& carver, std::uint32_t capacity) {
  SortScratch scratch{};
  Keys<std::uint64_t> keys;
  Values values;
  sort_in_buffers(nullptr, scratch.temporary_bytes, keys, values, capacity, nullptr);
  scratch.keys = carver.take<std::uint64_t>(capacity);
  scratch.values = carver.take<std::uint32_t>(capacity);
  scratch.temporary = carver.take<std::byte>(scratch.temporary_bytes);
  return scratch;
}

/// CUB sorts to and fro between two buffers, and the device's tuning decides where it ends. On
/// today's devices it takes eight passes and ends where it began, but for inputs that fit one
/// block, which it sorts in one: so copying back costs nothing where it would cost. Sorting from
/// one array to another without regard for the first would instead need 12 bytes more a pair.
void sort_pairs(std::uint64_t* keys, std::uint32_t* values, std::uint32_t count,
                const SortScratch& scratch, Stream stream) {
  if (count == 0) return;
  Keys<std::uint64_t> key_buffers(keys, scratch.keys);
  Values value_buffers(values, scratch.values);
  std::size_t bytes = scratch.temporary_bytes;
  sort_in_buffers(scratch.temporary, bytes, key_buffers, value_buffers, count, stream);
  if (key_buffers.Current() != keys) {
    copy_on_device(keys, key_buffers.Current(), count * sizeof(*keys), stream);
  }
  if (value_buffers.Current() != values) {
    copy_on_device(values, value_buffers.Current(), count * sizeof(*values), stream);
  }
}

DeviceArray<std::uint32_t> sort_values(DeviceArray<std::uint32_t> keys,
                                       DeviceArray<std::uint32_t> values) {
  if (values.empty()) return values;
  const Stream stream = values.stream();
  const std::uint32_t count = std::uint32_t(values.size());
  DeviceArray<std::uint32_t> other_keys(count, stream), other_values(count, stream);
  Keys<std::uint32_t> key_buffers(keys.data(), other_keys.data());
  Values value_buffers(values.data(), other_values.data());
  std::size_t bytes = 0;
  sort_in_buffers(nullptr, bytes, key_buffers, value_buffers, count, stream);
  DeviceArray<std::byte> temporary(bytes, stream);
  sort_in_buffers(temporary.data(), bytes, key_buffers, value_buffers, count, stream);
  return value_buffers.Current() == values.data() ? std::move(values) : std::move(other_values);
}

SumScratch carve_sum_scratch(Carver& carver, std::uint32_t capacity) {
  SumScratch scratch{};
  sum_in_memory<std::uint32_t>(nullptr, scratch.temporary_bytes, nullptr, nullptr, capacity,
                               nullptr);
  scratch.temporary = carver.take<std::byte>(scratch.temporary_bytes);
  return scratch;
}

void sum_before(const std::uint32_t* values, std::uint32_t* sums, std::uint32_t count,
                const SumScratch& scratch, Stream stream) {
  if (count == 0) return;
  std::size_t bytes = scratch.temporary_bytes;
  sum_in_memory(scratch.temporary, bytes, values, sums, count, stream);
}

void sum_before(std::int64_t* values, std::size_t count, Stream stream) {
  if (count == 0) return;
  std::size_t bytes = 0;
  sum_in_memory(nullptr, bytes, values, values, count, stream);
  DeviceArray<std::byte> temporary(bytes, stream);
  sum_in_memory(temporary.data(), bytes, values, values, count, stream);
}

}  // namespace treelet::cuda
