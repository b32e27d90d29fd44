#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace treelet {

/// The hash XXH64 [Collet2012, specification 0.1.1] of bytes: as fast as memory, and a change goes
/// unnoticed once in 2^64 times. Not against forgery: what reads untrusted bytes checks them
/// itself.
std::uint64_t xxh64(std::span<const std::byte> bytes, std::uint64_t seed = 0);

}  // namespace treelet
