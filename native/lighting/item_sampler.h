// SPDX-License-Identifier: GPL-3.0-or-later
// Points on a luminaire for one surface point: first a look, then as many as its error needs.
#pragma once

#include <span>
#include <vector>

#include "lighting/bounded_item.h"

namespace penumbra {

class Chords;

enum class LinesTaken { kYes, kTooDear, kUnfit };

class ItemSampler {
 public:
  ItemSampler(const Geometry& geometry, std::span<const Luminaire> luminaires, const Sampler& sampler,
              const std::vector<LitPoint>& points, const BoundedSettings& settings)
      : geometry_(geometry),
        luminaires_(luminaires),
        sampler_(sampler),
        points_(points),
        settings_(settings) {}

  /// Surface point number `point` and a luminaire of that form factor: its unshadowed light.
  LookedItem make(uint32_t point, uint32_t luminaire, double form_factor) const;

  /// The first rays of one luminaire's items, which want as many each; all points of a point light are the
  /// same. Those of a group (its number, by item) lie together; only they share packets.
  void look(std::span<LookedItem> items, std::span<const uint32_t> group, LightTally& tally) const;

  /// Adds points up to `count` (16, or a later level), shadow rays included.
  void advance(BoundedItem& item, uint32_t count, LightTally& tally) const;

  /// Whether lines across the luminaire tell all about it that points do.
  bool may_use_lines(const BoundedItem& item) const;
  /// So many lines instead of its points, or twice as many as it has; nothing changes where they are not
  /// taken: more triangles than `most` may be in the way, or lines are not good enough.
  LinesTaken advance_lines(BoundedItem& item, uint32_t lines, uint32_t most, Chords& chords,
                           LightTally& tally) const;

 private:
  StreamKey key(const LookedItem& item) const;
  void look_at_packets(std::span<LookedItem> items, const uint32_t* group, const Luminaire& luminaire,
                       uint32_t looks, LightTally& tally) const;
  Vec3d unshadowed_glossy(const ShadingPoint& point, const Vec3d& arriving, const Luminaire& luminaire,
                          const StreamKey& key) const;

  const Geometry& geometry_;
  std::span<const Luminaire> luminaires_;
  const Sampler& sampler_;
  const std::vector<LitPoint>& points_;
  const BoundedSettings& settings_;
};

}  // namespace penumbra
