// SPDX-License-Identifier: GPL-3.0-or-later
// Two-dimensional points for luminaires: a point sequence and its treatment from pixel to pixel.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace penumbra {

enum class SamplerKind { kPrs, kSprs, kSobol, kHalton, kOwenSobol };

/// What is done to one sequence so that it serves many pixels: the same points everywhere, one sequence
/// continued from pixel to pixel, Cranley-Patterson rotation, or nested uniform scrambling per pixel.
enum class SampleReuse { kSame, kContinued, kRotated, kScrambled };

/// Points are generated and traced in packets of this many.
inline constexpr uint32_t kPacket = 16;

struct SamplerSettings {
  SamplerKind kind = SamplerKind::kOwenSobol;
  SampleReuse reuse = SampleReuse::kScrambled;
  uint32_t seed = 0;
  /// Most points that one stream is asked for.
  uint32_t samples_per_stream = 64;
  /// Numbers of points, ascending: those between two of them are always used together, so they may come in
  /// another order, sorted along a Morton curve, which keeps a packet's rays together. Sets of points are the
  /// same either way.
  std::vector<uint32_t> levels{};
};

/// One use of the sampler: a luminaire seen from one shading point.
struct StreamKey {
  /// Consecutive number of the stream in the full frame; orders PRS and CONTINUED streams.
  uint64_t index;
  /// Number of the frame's streams that use the same points with SAME treatment; keys rotation and
  /// scrambling.
  uint64_t hash;
};

class Sampler {
 public:
  virtual ~Sampler() = default;

  /// Points first ... first + count - 1 of a stream, uniform in [0,1)^2. Both numbers are multiples of
  /// kPacket; u and v hold `count` floats, multiples of 2^-24 and at most 1 - 2^-24. Points at or beyond
  /// samples_per_stream have some value in [0,1)^2 and are not to be used.
  virtual void points(const StreamKey& key, uint32_t first, uint32_t count, float* u, float* v) const = 0;

  /// The first points of several streams, at most kPacket of each: point k of stream i is number
  /// k * keys.size() + i.
  virtual void first_points(std::span<const StreamKey> keys, uint32_t count, float* u, float* v) const;
};

/// Throws std::invalid_argument where SPRS is asked for a number that is no square, or for zero points.
std::unique_ptr<Sampler> make_sampler(const SamplerSettings& settings);

}  // namespace penumbra
