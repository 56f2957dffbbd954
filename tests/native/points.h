// SPDX-License-Identifier: GPL-3.0-or-later
// What the sampling tests share: points of a stream as arrays, and the count behind every net property.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sampling/hash.h"
#include "sampling/sampler.h"

namespace penumbra::test {

struct Points {
  std::vector<float> u, v;
  size_t size() const { return u.size(); }
};

/// Stream `index` as rendering keys it with one luminaire and one primary ray a pixel.
inline StreamKey key_of(uint64_t index) {
  return {index, hash_of(index)};
}

/// The first `count` points of a stream, asked for in one call of whole packets.
inline Points points_of(const Sampler& sampler, uint64_t stream, uint32_t count) {
  const uint32_t padded = (count + kPacket - 1) / kPacket * kPacket;
  Points p{std::vector<float>(padded), std::vector<float>(padded)};
  sampler.points(key_of(stream), 0, padded, p.u.data(), p.v.data());
  p.u.resize(count);
  p.v.resize(count);
  return p;
}

inline const std::vector<SamplerKind>& all_kinds() {
  static const std::vector<SamplerKind> kinds{SamplerKind::kPrs, SamplerKind::kSprs, SamplerKind::kSobol,
                                              SamplerKind::kHalton, SamplerKind::kOwenSobol};
  return kinds;
}

inline const std::vector<SampleReuse>& all_reuses() {
  static const std::vector<SampleReuse> reuses{SampleReuse::kSame, SampleReuse::kContinued,
                                               SampleReuse::kRotated, SampleReuse::kScrambled};
  return reuses;
}

inline std::string name_of(SamplerKind kind, SampleReuse reuse) {
  const char* kinds[] = {"PRS", "SPRS", "SOBOL", "HALTON", "OWEN_SOBOL"};
  const char* reuses[] = {"SAME", "CONTINUED", "ROTATED", "SCRAMBLED"};
  return std::string(kinds[int(kind)]) + " " + reuses[int(reuse)];
}

/// How many points fall into each of columns x rows equal cells; x and y: functions of the index, giving the
/// coordinate in units of 2^-32 (of a half-open cell; see the callers for truncated coordinates).
template <typename X, typename Y>
std::vector<uint32_t> count_cells(size_t first, size_t count, uint64_t columns, uint64_t rows, X x, Y y) {
  std::vector<uint32_t> cells(columns * rows, 0);
  for (size_t i = first; i < first + count; ++i)
    ++cells[(uint64_t(x(i)) * columns >> 32) * rows + (uint64_t(y(i)) * rows >> 32)];
  return cells;
}

inline bool all_equal(const std::vector<uint32_t>& counts, uint32_t expected) {
  for (uint32_t n : counts)
    if (n != expected) return false;
  return true;
}

/// A float in [0, 1) in units of 2^-32, exact.
inline uint64_t fixed32(float x) {
  return uint64_t(double(x) * 0x1p32);
}

}  // namespace penumbra::test
