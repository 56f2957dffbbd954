// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/sequences.h"

#include <bit>

#include "sampling/hash.h"

namespace penumbra {
namespace {

/// Sobol's recurrence for a primitive polynomial x^d + a_1 x^(d-1) + ... + 1 (coefficients a_1 .. a_(d-1) in
/// the bits of `inner`, a_1 highest): v_i = a_1 v_(i-1) ^ ... ^ v_(i-d) ^ (v_(i-d) >> d), on left-aligned
/// v_i.
constexpr std::array<uint32_t, 32> sobol_columns(int degree, uint32_t inner,
                                                 std::array<uint32_t, 5> initial) {
  std::array<uint32_t, 32> v{};
  for (int i = 0; i < degree; ++i) v[i] = initial[i] << (31 - i);
  for (int i = degree; i < 32; ++i) {
    v[i] = v[i - degree] ^ (v[i - degree] >> degree);
    for (int k = 1; k < degree; ++k)
      if ((inner >> (degree - 1 - k)) & 1) v[i] ^= v[i - k];
  }
  return v;
}

constexpr std::array<uint32_t, 32> identity_columns() {
  std::array<uint32_t, 32> v{};
  for (int i = 0; i < 32; ++i) v[i] = 0x80000000u >> i;
  return v;
}

uint32_t radical_inverse_base2(uint64_t index) {
  return reverse_bits(uint32_t(index));
}

/// floor(2^32 * radical inverse in base 3), exact: the numerator and 3^digits are kept as integers.
uint32_t radical_inverse_base3(uint64_t index) {
  unsigned __int128 numerator = 0, denominator = 1;
  for (; index; index /= 3) {
    numerator = numerator * 3 + index % 3;
    denominator *= 3;
  }
  return uint32_t((numerator << 32) / denominator);
}

/// 21 ternary digits reach below 2^-32.
constexpr int kTernaryDigits = 21;

uint32_t scrambled_radical_inverse_base3(uint64_t index, uint64_t seed) {
  uint64_t prefix = 1, numerator = 0, denominator = 1;  // prefix: the digits so far, with their number
  for (int d = 0; d < kTernaryDigits; ++d) {
    uint32_t digit = index % 3;
    index /= 3;
    // One of the six permutations of {0,1,2}: a rotation, and perhaps a reflection.
    const uint32_t permutation = uint32_t(((hash_of(seed, prefix) >> 32) * 6) >> 32);
    prefix = prefix * 3 + digit;
    digit = (permutation & 1 ? 3 - digit : digit) + permutation / 2;
    numerator = numerator * 3 + digit % 3;
    denominator *= 3;
  }
  return uint32_t(((unsigned __int128)numerator << 32) / denominator);
}

}  // namespace

constexpr DigitalMatrices kNumericalRecipesSobol = {sobol_columns(1, 0, {1}), sobol_columns(2, 1, {1, 1})};
constexpr DigitalMatrices kZeroTwoSobol = {identity_columns(), sobol_columns(1, 0, {1})};

/// The first eight dimensions of S. Joe and F. Y. Kuo's table new-joe-kuo-6 (2008).
constexpr DigitalMatrices kSobolPixel = {identity_columns(), sobol_columns(1, 0, {1})};
constexpr DigitalMatrices kSobolLight = {sobol_columns(2, 1, {1, 3}), sobol_columns(3, 1, {1, 3, 1})};
constexpr DigitalMatrices kSobolLens = {sobol_columns(3, 2, {1, 1, 1}), sobol_columns(4, 1, {1, 1, 3, 3})};
constexpr DigitalMatrices kSobolTime = {sobol_columns(4, 4, {1, 3, 5, 13}),
                                        sobol_columns(5, 2, {1, 1, 5, 5, 17})};

FixedPoint2 digital_point(const DigitalMatrices& matrices, uint32_t index) {
  FixedPoint2 p{0, 0};
  for (uint32_t gray = index ^ (index >> 1); gray; gray &= gray - 1) {
    const int column = std::countr_zero(gray);
    p.u ^= matrices.u[column];
    p.v ^= matrices.v[column];
  }
  return p;
}

FixedPoint2 next_digital_point(const DigitalMatrices& matrices, FixedPoint2 point, uint32_t next_index) {
  if (next_index == 0) return {0, 0};  // 2^32 points later the sequence starts again
  const int column = std::countr_zero(next_index);
  return {point.u ^ matrices.u[column], point.v ^ matrices.v[column]};
}

FixedPoint2 halton_point(uint64_t index) {
  return {radical_inverse_base2(index), radical_inverse_base3(index)};
}

FixedPoint2 scrambled_halton_point(uint64_t index, uint64_t seed) {
  const uint64_t h = mix_bits(seed);
  return {reverse_bits(owen_scramble_reversed(uint32_t(index), uint32_t(h))),
          scrambled_radical_inverse_base3(index, h)};
}

}  // namespace penumbra
