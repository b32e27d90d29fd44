#pragma once

#include "emulator/attributes.h"

// Short vectors with CUDA's alignment.

#define TREELET_EMULATOR_VECTORS(Base, Scalar, align2, align4)                         \
  struct Base##1 { Scalar x; };                                                        \
  struct __align__(align2) Base##2 { Scalar x, y; };                                   \
  struct Base##3 { Scalar x, y, z; };                                                  \
  struct __align__(align4) Base##4 { Scalar x, y, z, w; };                             \
  constexpr Base##1 make_##Base##1(Scalar x) { return {x}; }                           \
  constexpr Base##2 make_##Base##2(Scalar x, Scalar y) { return {x, y}; }              \
  constexpr Base##3 make_##Base##3(Scalar x, Scalar y, Scalar z) { return {x, y, z}; } \
  constexpr Base##4 make_##Base##4(Scalar x, Scalar y, Scalar z, Scalar w) { return {x, y, z, w}; }

TREELET_EMULATOR_VECTORS(char, signed char, 2, 4)
TREELET_EMULATOR_VECTORS(uchar, unsigned char, 2, 4)
TREELET_EMULATOR_VECTORS(short, short, 4, 8)
TREELET_EMULATOR_VECTORS(ushort, unsigned short, 4, 8)
TREELET_EMULATOR_VECTORS(int, int, 8, 16)
TREELET_EMULATOR_VECTORS(uint, unsigned, 8, 16)
TREELET_EMULATOR_VECTORS(float, float, 8, 16)
TREELET_EMULATOR_VECTORS(double, double, 16, 16)
TREELET_EMULATOR_VECTORS(longlong, long long, 16, 16)
TREELET_EMULATOR_VECTORS(ulonglong, unsigned long long, 16, 16)

#undef TREELET_EMULATOR_VECTORS

struct dim3 {
  unsigned x = 1, y = 1, z = 1;

  constexpr dim3(unsigned vx = 1, unsigned vy = 1, unsigned vz = 1) : x(vx), y(vy), z(vz) {}
  constexpr dim3(uint3 v) : x(v.x), y(v.y), z(v.z) {}
  constexpr operator uint3() const { return {x, y, z}; }
};
