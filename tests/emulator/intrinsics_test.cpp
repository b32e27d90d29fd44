#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace treelet::emulator::test {
namespace {

TEST(Intrinsics, Bits) {
  EXPECT_EQ(__popc(0xf0f0u), 8);
  EXPECT_EQ(__popcll(~0ull), 64);
  EXPECT_EQ(__clz(0), 32);
  EXPECT_EQ(__clz(-1), 0);
  EXPECT_EQ(__clzll(1), 63);
  EXPECT_EQ(__ffs(0), 0);
  EXPECT_EQ(__ffs(8), 4);
  EXPECT_EQ(__ffsll(1ll << 40), 41);
  EXPECT_EQ(__brev(0x00000003u), 0xc0000000u);
  EXPECT_EQ(__brevll(1ull), 1ull << 63);
}

TEST(Intrinsics, Words) {
  EXPECT_EQ(__umulhi(0xffffffffu, 0xffffffffu), 0xfffffffeu);
  EXPECT_EQ(__mulhi(-1, 1), -1);
  EXPECT_EQ(__umul64hi(1ull << 63, 6), 3ull);
  EXPECT_EQ(__byte_perm(0x33221100u, 0x77665544u, 0x7520u), 0x77552200u);
  EXPECT_EQ(__byte_perm(0x00008000u, 0u, 0x9999u), 0xffffffffu) << "copies of a sign";
  EXPECT_EQ(__funnelshift_l(0x80000000u, 0x00000001u, 1), 3u);
  EXPECT_EQ(__funnelshift_r(0x80000000u, 0x00000001u, 31), 3u);
  EXPECT_EQ(__funnelshift_l(5u, 9u, 32), 9u) << "shifts modulo 32";
}

TEST(Intrinsics, Casts) {
  EXPECT_EQ(__float_as_uint(1.0f), 0x3f800000u);
  EXPECT_EQ(__uint_as_float(0x40000000u), 2.0f);
  EXPECT_EQ(__longlong_as_double(__double_as_longlong(-2.5)), -2.5);
}

TEST(Intrinsics, FloatsRoundOnce) {
  const float a = 1.0f + 0x1p-12f;
  EXPECT_EQ(__fmaf_rn(a, a, -1.0f), 0x1p-11f + 0x1p-24f);
  EXPECT_EQ(__fadd_rn(__fmul_rn(a, a), -1.0f), 0x1p-11f);
  EXPECT_EQ(__fsqrt_rn(2.0f), std::sqrt(2.0f));
}

TEST(Intrinsics, MinAndMaxPreferNumbers) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(min(nan, 1.0f), 1.0f);
  EXPECT_EQ(max(1.0f, nan), 1.0f);
  EXPECT_EQ(min(-1, 2u), 2u) << "as CUDA: the int becomes unsigned";
  EXPECT_EQ(max(3ll, -4ll), 3ll);
}

TEST(VectorTypes, HaveTheAlignmentOfCuda) {
  EXPECT_EQ(alignof(float2), 8u);
  EXPECT_EQ(alignof(float3), 4u);
  EXPECT_EQ(alignof(float4), 16u);
  EXPECT_EQ(sizeof(uchar4), 4u);
  EXPECT_EQ(alignof(ulonglong2), 16u);
  EXPECT_EQ(make_int4(1, 2, 3, 4).w, 4);
}

}  // namespace
}  // namespace treelet::emulator::test
