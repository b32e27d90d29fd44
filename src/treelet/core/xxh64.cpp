#include <treelet/core/xxh64.h>

#include <bit>
#include <cstring>

namespace treelet {
namespace {

constexpr std::uint64_t kPrime1 = 0x9e3779b185ebca87, kPrime2 = 0xc2b2ae3d27d4eb4f,
                        kPrime3 = 0x165667b19e3779f9, kPrime4 = 0x85ebca77c2b2ae63,
                        kPrime5 = 0x27d4eb2f165667c5;
constexpr std::size_t kStripe = 32;

/// Little-endian on every machine.
template <class T>
T read(const std::byte* from) {
  if constexpr (std::endian::native == std::endian::little) {
    T value;
    std::memcpy(&value, from, sizeof(T));
    return value;
  } else {
    T value = 0;
    for (std::size_t i = sizeof(T); i-- > 0;) value = value << 8 | T(from[i]);
    return value;
  }
}

std::uint64_t mix(std::uint64_t accumulator, std::uint64_t lane) {
  return std::rotl(accumulator + lane * kPrime2, 31) * kPrime1;
}

/// Whole stripes in four lanes; moves `from` to where they end.
std::uint64_t hash_stripes(const std::byte*& from, const std::byte* end, std::uint64_t seed) {
  std::uint64_t lanes[4] = {seed + kPrime1 + kPrime2, seed + kPrime2, seed, seed - kPrime1};
  for (; end - from >= std::ptrdiff_t(kStripe); from += kStripe) {
    for (int i = 0; i < 4; ++i) lanes[i] = mix(lanes[i], read<std::uint64_t>(from + 8 * i));
  }
  std::uint64_t hash = std::rotl(lanes[0], 1) + std::rotl(lanes[1], 7) + std::rotl(lanes[2], 12) +
                       std::rotl(lanes[3], 18);
  for (const std::uint64_t lane : lanes) hash = (hash ^ mix(0, lane)) * kPrime1 + kPrime4;
  return hash;
}

std::uint64_t hash_rest(const std::byte* from, const std::byte* end, std::uint64_t hash) {
  for (; end - from >= 8; from += 8) {
    hash = std::rotl(hash ^ mix(0, read<std::uint64_t>(from)), 27) * kPrime1 + kPrime4;
  }
  if (end - from >= 4) {
    hash = std::rotl(hash ^ read<std::uint32_t>(from) * kPrime1, 23) * kPrime2 + kPrime3;
    from += 4;
  }
  for (; from != end; ++from) {
    hash = std::rotl(hash ^ std::uint64_t(*from) * kPrime5, 11) * kPrime1;
  }
  return hash;
}

}  // namespace

std::uint64_t xxh64(std::span<const std::byte> bytes, std::uint64_t seed) {
  const std::byte* from = bytes.data();
  const std::byte* const end = from + bytes.size();
  std::uint64_t hash = bytes.size() >= kStripe ? hash_stripes(from, end, seed) : seed + kPrime5;
  hash = hash_rest(from, end, hash + bytes.size());
  hash = (hash ^ hash >> 33) * kPrime2;
  hash = (hash ^ hash >> 29) * kPrime3;
  return hash ^ hash >> 32;
}

}  // namespace treelet
