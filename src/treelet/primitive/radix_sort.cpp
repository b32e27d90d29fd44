#include <treelet/primitive/radix_sort.h>

#include <algorithm>
#include <array>
#include <bit>
#include <utility>
#include <vector>

#include <treelet/core/parallel.h>

// Most significant digit first, in parallel, until a bucket fits into the cache; then least
// significant digit first within it. A plain LSD sort moves all entries through memory once a
// digit; this one moves them about twice.

namespace treelet {
namespace {

constexpr int kMsdBits = 11;
constexpr std::size_t kMsdBuckets = std::size_t{1} << kMsdBits;
constexpr int kLsdBits = 8;
constexpr std::size_t kLsdBuckets = std::size_t{1} << kLsdBits;
constexpr int kLsdDigits = 3;

constexpr std::size_t kGrain = 1 << 16;             // entries of one histogram of the parallel pass
constexpr std::size_t kCacheEntries = 1 << 15;      // 512 KiB: entries and their copy in half an L2
constexpr std::size_t kComparisonEntries = 1 << 7;  // below, histograms cost more than comparisons

using Entries = std::span<SortEntry>;

/// Sorts `data`, whose keys all agree above key_bits; `scratch` has the same size.
void sort_in_place(Entries data, Entries scratch, int key_bits);

std::size_t digit(std::uint64_t key, int shift, std::size_t buckets) {
  return key >> shift & (buckets - 1);
}

void sort_by_comparison(Entries data) {
  std::sort(data.begin(), data.end(), [](const SortEntry& a, const SortEntry& b) {
    return a.key != b.key ? a.key < b.key : a.value < b.value;
  });
}

void scatter_by_digit(Entries from, Entries to, int shift) {
  std::array<std::uint32_t, kLsdBuckets> position{};
  for (const SortEntry& entry : from) ++position[digit(entry.key, shift, kLsdBuckets)];
  std::uint32_t total = 0;
  for (std::uint32_t& p : position) total += std::exchange(p, total);
  for (const SortEntry& entry : from) to[position[digit(entry.key, shift, kLsdBuckets)]++] = entry;
}

/// Sorts runs of entries whose keys agree above `shift`.
void sort_ties(Entries data, int shift) {
  for (std::size_t begin = 0; begin + 1 < data.size();) {
    std::size_t end = begin + 1;
    while (end < data.size() && data[end].key >> shift == data[begin].key >> shift) ++end;
    if (end - begin > 1) sort_by_comparison(data.subspan(begin, end - begin));
    begin = end;
  }
}

/// Least significant digit first over the upper bits, which tell nearly all of so few keys apart.
void sort_in_cache(Entries data, Entries scratch, int key_bits) {
  const int first_shift = std::max(key_bits - kLsdDigits * kLsdBits, 0);
  Entries from = data, to = scratch;
  for (int shift = first_shift; shift < key_bits; shift += kLsdBits) {
    scatter_by_digit(from, to, shift);
    std::swap(from, to);
  }
  if (first_shift > 0) sort_ties(from, first_shift);
  if (from.data() != data.data()) std::copy(from.begin(), from.end(), data.begin());
}

using Histogram = std::array<std::size_t, kMsdBuckets>;

/// Turns the counts of each range into the position of its first entry of each bucket; returns
/// where the buckets begin.
std::vector<std::size_t> scan_histograms(std::vector<Histogram>& histograms) {
  std::vector<std::size_t> bucket_begin;
  std::size_t total = 0;
  for (std::size_t bucket = 0; bucket < kMsdBuckets; ++bucket) {
    bucket_begin.push_back(total);
    for (Histogram& histogram : histograms) total += std::exchange(histogram[bucket], total);
  }
  bucket_begin.push_back(total);
  return bucket_begin;
}

std::vector<std::size_t> scatter_into_buckets(Entries from, Entries to, int shift) {
  std::vector<Histogram> histograms((from.size() + kGrain - 1) / kGrain, Histogram{});
  parallel_for_ranges(from.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    Histogram& histogram = histograms[begin / kGrain];
    for (std::size_t i = begin; i < end; ++i) ++histogram[digit(from[i].key, shift, kMsdBuckets)];
  });
  std::vector<std::size_t> bucket_begin = scan_histograms(histograms);
  parallel_for_ranges(from.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    Histogram& position = histograms[begin / kGrain];
    for (std::size_t i = begin; i < end; ++i) {
      to[position[digit(from[i].key, shift, kMsdBuckets)]++] = from[i];
    }
  });
  return bucket_begin;
}

/// Leaves the sorted entries in `to`.
void sort_by_buckets(Entries from, Entries to, int key_bits) {
  const int shift = std::max(key_bits - kMsdBits, 0);
  const std::vector<std::size_t> bucket_begin = scatter_into_buckets(from, to, shift);
  parallel_for(kMsdBuckets, 1, [&](std::size_t bucket) {
    const std::size_t begin = bucket_begin[bucket], size = bucket_begin[bucket + 1] - begin;
    sort_in_place(to.subspan(begin, size), from.subspan(begin, size), shift);
  });
}

void sort_in_place(Entries data, Entries scratch, int key_bits) {
  if (key_bits == 0) return;
  if (data.size() <= kComparisonEntries) return sort_by_comparison(data);
  if (data.size() <= kCacheEntries) return sort_in_cache(data, scratch, key_bits);
  sort_by_buckets(data, scratch, key_bits);
  std::copy(scratch.begin(), scratch.end(), data.begin());
}

/// Bits up to the highest in which two keys differ.
int differing_bits(Entries entries) {
  struct Masks {
    std::uint64_t all = ~std::uint64_t{0}, any = 0;
  };
  const Masks masks = parallel_reduce(
      entries.size(), kGrain, Masks{},
      [&](std::size_t begin, std::size_t end) {
        Masks range;
        for (const SortEntry& entry : entries.subspan(begin, end - begin)) {
          range.all &= entry.key;
          range.any |= entry.key;
        }
        return range;
      },
      [](Masks a, Masks b) { return Masks{a.all & b.all, a.any | b.any}; });
  return int(std::bit_width(masks.any & ~masks.all));
}

}  // namespace

void radix_sort(Array<SortEntry>& entries) {
  if (entries.size() < 2) return;
  const int key_bits = differing_bits(entries);
  if (key_bits == 0) return;
  if (entries.size() <= kComparisonEntries) return sort_by_comparison(entries);
  Array<SortEntry> sorted(entries.size());
  sort_by_buckets(entries, sorted, key_bits);
  entries = std::move(sorted);
}

}  // namespace treelet
