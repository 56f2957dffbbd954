// SPDX-License-Identifier: GPL-3.0-or-later
// The low-discrepancy sequences themselves, as 32-bit binary fractions, before any per-pixel treatment.
#pragma once

#include <array>
#include <cstdint>

namespace penumbra {

/// A point of the unit square, each coordinate x in units of 2^-32.
struct FixedPoint2 {
  uint32_t u, v;
};

/// Direction numbers of a two-dimensional digital sequence in base 2: column k is v_k, its first digit in
/// the highest bit.
struct DigitalMatrices {
  std::array<uint32_t, 32> u, v;
};

/// Sobol' after Numerical Recipes, 2nd ed., sec. 7.7: primitive polynomials x + 1 and x^2 + x + 1, initial
/// numbers 1 and 1, 1. A (1,2)-sequence in base 2.
extern const DigitalMatrices kNumericalRecipesSobol;

/// Van der Corput x the second Sobol' dimension (Pascal's triangle mod 2): a (0,2)-sequence in base 2.
extern const DigitalMatrices kZeroTwoSobol;

/// Sobol' in seven dimensions, two each for the places in the pixel, on the luminaire and on the lens, and
/// one, the first of a pair, for time: together they are stratified as padded ones are not.
extern const DigitalMatrices kSobolPixel, kSobolLight, kSobolLens, kSobolTime;

/// Point of a digital sequence in the order of Antonov and Saleev, which Numerical Recipes uses: the
/// exclusive or of the columns that the digits of the index's Gray code select. Blocks [j 2^k, (j+1) 2^k)
/// hold the same points as in the natural order.
FixedPoint2 digital_point(const DigitalMatrices& matrices, uint32_t index);

/// The point after `point`, which has index `next_index - 1`: one column changes.
FixedPoint2 next_digital_point(const DigitalMatrices& matrices, FixedPoint2 point, uint32_t next_index);

/// Halton point in bases 2 and 3, floor(x 2^32) of the exact rational.
FixedPoint2 halton_point(uint64_t index);

/// Halton point with each digit permuted at random by all digits before it (Owen scrambling in bases 2 and
/// 3).
FixedPoint2 scrambled_halton_point(uint64_t index, uint64_t seed);

}  // namespace penumbra
