// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/sequence_sampler.h"

#include <algorithm>
#include <numeric>

#include "math/simd.h"
#include "sampling/hash.h"

namespace penumbra {
namespace {

/// What one stream does to the points of the sequence.
struct Treatment {
  uint32_t scramble_u = 0, scramble_v = 0, shift_u = 0, shift_v = 0;
};

/// Digits, in reverse order where they are to be scrambled, shifted modulo 1, and rounded down to 24 bits, so
/// that 1 can't occur.
PENUMBRA_VECTORIZED
void to_unit_square(const uint32_t* in, uint32_t count, bool owen, uint32_t scramble, uint32_t shift,
                    float* out) {
  if (owen) {
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t x = reverse_bits(owen_scramble_reversed(in[i], scramble)) + shift;
      out[i] = float(int32_t(x >> 8)) * 0x1p-24f;
    }
  } else {
    for (uint32_t i = 0; i < count; ++i) out[i] = float(int32_t((in[i] + shift) >> 8)) * 0x1p-24f;
  }
}

/// One point of the sequence, its digits reversed, scrambled for each of many streams.
PENUMBRA_VECTORIZED
void scramble_each(uint32_t reversed, const uint32_t* seeds, uint32_t count, float* out) {
  for (uint32_t i = 0; i < count; ++i)
    out[i] = float(int32_t(reverse_bits(owen_scramble_reversed(reversed, seeds[i])) >> 8)) * 0x1p-24f;
}

/// Cells of a Morton curve, enough to tell the packets of 2^14 points apart.
constexpr int kCurveDigits = 5;
constexpr uint32_t kCells = 1u << 2 * kCurveDigits;

/// Interleaves the highest digits of both coordinates.
uint32_t cell_of(FixedPoint2 point) {
  uint32_t cell = 0;
  for (int bit = 31; bit > 31 - kCurveDigits; --bit)
    cell = cell << 2 | (point.u >> bit & 1) << 1 | (point.v >> bit & 1);
  return cell;
}

/// Numbers of points, ascending at first, in the order of the curve.
void sort_along_curve(const std::vector<FixedPoint2>& points, std::span<uint32_t> numbers) {
  std::vector<uint32_t> next(kCells + 1), sorted(numbers.size());  // next place in each cell
  for (uint32_t i : numbers) ++next[cell_of(points[i]) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  for (uint32_t i : numbers) sorted[next[cell_of(points[i])]++] = i;
  std::copy(sorted.begin(), sorted.end(), numbers.begin());
}

}  // namespace

SequenceSampler::SequenceSampler(const SamplerSettings& settings) : settings_(settings) {
  if (settings.kind == SamplerKind::kSobol) matrices_ = &kNumericalRecipesSobol;
  if (settings.kind == SamplerKind::kOwenSobol) matrices_ = &kZeroTwoSobol;
  const bool scrambled = settings.reuse == SampleReuse::kScrambled;
  scrambled_halton_ = settings.kind == SamplerKind::kHalton && scrambled;
  owen_ = settings.kind == SamplerKind::kOwenSobol || (settings.kind == SamplerKind::kSobol && scrambled);
  // Sobol' after the book, and Halton, leave out the origin; there the seed is another place to start. An
  // Owen-scrambled sequence has no corner to avoid, and a (0,2)-sequence wants blocks that start at 0.
  start_ = settings.kind == SamplerKind::kOwenSobol ? 0 : uint64_t(1) + settings.seed;
  if (settings.reuse != SampleReuse::kContinued) fill_table();
}

FixedPoint2 SequenceSampler::base_point(uint64_t index) const {
  index += start_;
  return matrices_ ? digital_point(*matrices_, uint32_t(index)) : halton_point(index);
}

void SequenceSampler::base_points(uint64_t index, uint32_t count, FixedPoint2* out) const {
  out[0] = base_point(index);
  for (uint32_t i = 1; i < count; ++i)
    out[i] = matrices_ ? next_digital_point(*matrices_, out[i - 1], uint32_t(start_ + index + i))
                       : base_point(index + i);
}

void SequenceSampler::fill_table() {
  const uint32_t count = (settings_.samples_per_stream + kPacket - 1) / kPacket * kPacket;
  std::vector<FixedPoint2> points(count);
  base_points(0, count, points.data());
  index_.resize(count);
  std::iota(index_.begin(), index_.end(), 0u);
  // Scrambling and digit order keep neighbours together.
  for (size_t i = 1; i < settings_.levels.size(); ++i)
    sort_along_curve(points, std::span(index_).subspan(settings_.levels[i - 1],
                                                       settings_.levels[i] - settings_.levels[i - 1]));
  for (uint32_t i : index_) {
    u_.push_back(digits(points[i].u));
    v_.push_back(digits(points[i].v));
  }
}

void SequenceSampler::points(const StreamKey& key, uint32_t first, uint32_t count, float* u, float* v) const {
  // A pixel's own numbers with ROTATED and SCRAMBLED; the frame's with SAME and CONTINUED.
  const bool per_stream =
      settings_.reuse == SampleReuse::kRotated || settings_.reuse == SampleReuse::kScrambled;
  const uint64_t bits = hash_of(settings_.seed, per_stream ? key.hash : 0);
  Treatment t;
  if (owen_) {
    // With ROTATED the scrambling is the frame's and the shift the stream's.
    const uint64_t s = settings_.reuse == SampleReuse::kRotated ? hash_of(settings_.seed, 0) : bits;
    t.scramble_u = uint32_t(s);
    t.scramble_v = uint32_t(s >> 32);
  }
  if (settings_.reuse == SampleReuse::kRotated) {
    t.shift_u = uint32_t(bits);
    t.shift_v = uint32_t(bits >> 32);
  }

  constexpr uint32_t kChunk = 64;
  alignas(64) uint32_t chunk_u[kChunk], chunk_v[kChunk];
  for (uint32_t done = 0; done < count; done += kChunk) {
    const uint32_t n = std::min(kChunk, count - done);
    const uint32_t *in_u = chunk_u, *in_v = chunk_v;
    if (settings_.reuse == SampleReuse::kContinued) {
      FixedPoint2 run[kChunk];
      base_points(key.index * settings_.samples_per_stream + first + done, n, run);
      for (uint32_t i = 0; i < n; ++i) {
        chunk_u[i] = digits(run[i].u);
        chunk_v[i] = digits(run[i].v);
      }
    } else if (scrambled_halton_) {
      for (uint32_t i = 0; i < n; ++i) {
        const FixedPoint2 p = scrambled_halton_point(start_ + index_[first + done + i], bits);
        chunk_u[i] = p.u;
        chunk_v[i] = p.v;
      }
    } else {
      in_u = u_.data() + first + done;
      in_v = v_.data() + first + done;
    }
    to_unit_square(in_u, n, owen_, t.scramble_u, t.shift_u, u + done);
    to_unit_square(in_v, n, owen_, t.scramble_v, t.shift_v, v + done);
  }
}

void SequenceSampler::first_points(std::span<const StreamKey> keys, uint32_t count, float* u,
                                   float* v) const {
  if (!owen_ || settings_.reuse != SampleReuse::kScrambled) return Sampler::first_points(keys, count, u, v);
  alignas(64) uint32_t seeds_u[kPacket], seeds_v[kPacket];
  const size_t streams = keys.size();
  for (size_t begin = 0; begin < streams; begin += kPacket) {
    const uint32_t n = uint32_t(std::min<size_t>(kPacket, streams - begin));
    for (uint32_t i = 0; i < n; ++i) {
      const uint64_t bits = hash_of(settings_.seed, keys[begin + i].hash);
      seeds_u[i] = uint32_t(bits), seeds_v[i] = uint32_t(bits >> 32);
    }
    for (uint32_t k = 0; k < count; ++k) {
      scramble_each(u_[k], seeds_u, n, u + k * streams + begin);
      scramble_each(v_[k], seeds_v, n, v + k * streams + begin);
    }
  }
}

}  // namespace penumbra
