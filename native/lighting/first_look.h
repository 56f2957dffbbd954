// SPDX-License-Identifier: GPL-3.0-or-later
// BOUNDED's first look: a few rays from each surface point to each luminaire that is not too dim for any.
#pragma once

#include <vector>

#include "lighting/item_sampler.h"

namespace penumbra {

class FirstLook {
 public:
  /// drop_share: of each pixel's tolerance, what dim luminaires may be charged for being dropped. Items of
  /// the block's points, as they are found. dim_size: quads of pixels where a luminaire is dimmer (display
  /// units) look at one point of it, at two below twice that.
  FirstLook(const ItemSampler& sampler, const Block& block, std::span<const Luminaire> luminaires,
            const std::vector<LitPoint>& points, const BoundedSettings& settings, double drop_share,
            BlockMemory& memory, double dim_size = 0);

  /// Some more of the points, which are all of some 2 x 2 quads of the frame's pixels; their items, one
  /// luminaire after the other, good until the next call. None: so few that it pays to wait for more, or,
  /// where all points were found, no more.
  std::span<const LookedItem> next(bool all_found, LightTally& tally);

  /// Items that are too dim for a ray.
  const std::vector<LookedItem>& dropped() const { return dropped_; }

 private:
  /// At most kBatch of the points that it is at: what luminaires ask, and what becomes of their light.
  struct Chunk {
    SurfaceColumns surfaces;
    alignas(64) double throughput[3][kBatch], albedo[3][kBatch];  // r, g, b
    bool in_core[kBatch];
    bool other_lobes[kBatch];  // than Lambert's
    bool any_other_lobes = false;
  };
  struct Candidate {
    double size;
    uint32_t point, luminaire;
  };

  uint32_t find_quads(uint32_t begin);
  void fill_chunks(uint32_t begin, uint32_t end);
  void find_sizes(uint32_t begin, LightTally& tally);
  void drop_dim_items(uint32_t begin, uint32_t end, LightTally& tally);
  void make_items(uint32_t begin, uint32_t end);
  void choose_looks(uint32_t count, uint32_t luminaire);
  LookedItem item(uint32_t point, uint32_t luminaire, size_t entry) const;
  static void light_sizes(const Chunk& chunk, const Vec3d& radiance, double display_scale,
                          const double* form_factors, double* sizes);

  /// Where a luminaire's number for a chunk's first point is.
  size_t entry_of(size_t chunk, uint32_t luminaire) const {
    return (chunk * luminaires_.size() + luminaire) * kBatch;
  }
  /// Where that for a point is, counted from the first that it is at.
  size_t entry_of_point(uint32_t at, uint32_t luminaire) const {
    return entry_of(at / kBatch, luminaire) + at % kBatch;
  }

  const ItemSampler& sampler_;
  const Block& block_;
  std::span<const Luminaire> luminaires_;
  const std::vector<LitPoint>& points_;
  const BoundedSettings& settings_;
  double drop_share_, dim_size_;
  uint32_t batch_;
  uint32_t looked_at_ = 0;  // points
  // Of the quads that it is at: each point's quad, the points, numbers by chunk, luminaire and point (a size
  // of 0: no item), what other lobes than Lambert's get and where it is, the items.
  std::vector<uint32_t> quad_, group_;
  std::vector<uint8_t> looks_;  // by point, of one luminaire
  Reused<Chunk> chunks_;
  Reused<double> form_factors_, sizes_;
  std::vector<LookedItem> by_other_lobes_;
  std::vector<uint32_t> by_other_lobes_at_;
  std::vector<Candidate> candidates_;
  Reused<LookedItem> items_;
  Reused<LookedItem> dropped_;
};

}  // namespace penumbra
