// SPDX-License-Identifier: GPL-3.0-or-later
// Samples of filtered pixels, a packet at a time: from places in the pixel to what each luminaire sends.
#pragma once

#include <optional>
#include <span>

#include "render/block.h"
#include "render/filtered_pixel.h"
#include "visibility/shadow_rays.h"

namespace penumbra {

/// Consecutive samples of one pixel.
struct SampleRun {
  uint32_t pixel;  // of the block
  uint32_t first, count;
  bool all = false;  // with rays to all luminaires
};

/// What a packet's samples get from one slot, by lane.
struct SlotColumns {
  static constexpr int32_t kNoRay = -1;    // none was wanted
  static constexpr int32_t kNothing = -2;  // nothing arrives, the rest is not set
  static constexpr int32_t kRays = -3;     // a packet of them, whose result is known

  uint32_t slot;
  VectorColumns unshadowed;
  double weight[kPacket];  // of the points on the luminaire, display units
  double seen[kPacket];    // share of it, by kRays
  int32_t ray[kPacket];    // number among the packet's shadow rays

  explicit SlotColumns(uint32_t s) : slot(s) { std::fill_n(ray, kPacket, kNothing); }
  void set(uint32_t lane, const Vec3d& light, double w, int32_t r, double share = 0) {
    unshadowed.set(lane, light);
    weight[lane] = w;
    seen[lane] = share;
    ray[lane] = r;
  }
  bool arrives(uint32_t lane) const { return ray[lane] != kNothing; }
  bool traced(uint32_t lane) const { return ray[lane] >= 0 || ray[lane] == kRays; }
};

/// Where the pixels of a block are, and their slots.
struct FilteredFrame {
  Rectangle area;  // of the block with its halo, full-frame pixels
  uint32_t block_width;
  bool glossy;  // some material has such a lobe: two slots for each luminaire and bounce
  uint32_t slot_count;
  Reused<Slot> slots;              // by pixel
  std::vector<uint8_t> edge;       // by pixel: needs samples all over the filter
  std::vector<uint8_t> uncertain;  // by pixel: the first look is not enough

  std::span<Slot> of_pixel(uint32_t p) { return {slots.data() + size_t(p) * slot_count, slot_count}; }
  std::span<const Slot> of_pixel(uint32_t p) const {
    return {slots.data() + size_t(p) * slot_count, slot_count};
  }
};

/// Empty slots for the pixels of a block.
FilteredFrame make_frame(const RenderContext& context, const Rectangle& area, const Block& block);

class SamplePacket {
 public:
  SamplePacket(const RenderContext& context, const FilteredFrame& frame, RenderTally& tally);

  /// Traces at most kPacket samples; lanes are numbered through the runs. Rays to luminaires are traced for
  /// a pixel's first samples, and later for slots that are uncertain.
  void trace(std::span<const SampleRun> runs);
  /// The camera rays of at most kPacket samples, and what they meet first, alone.
  void look(std::span<const SampleRun> runs);
  /// Which luminaires one of them sees itself.
  uint64_t lights_seen(uint32_t lane) const { return c_.paths.lights_seen(rays_[lane], hits[lane]); }

  // Of the last packet, by lane:
  double dx[kPacket], dy[kPacket];  // place, pixels from the pixel's centre
  Hit hits[kPacket];                // of the camera ray
  PathEnd ends[kPacket];
  double charge[kPacket];     // error of dim luminaires that were left out, display units
  uint32_t rays_of[kPacket];  // shadow rays
  // Only where passes want them:
  std::optional<LightParts> parts;  // of all but the contributions
  std::vector<std::vector<MatteHit>> mattes;
  std::vector<SeenObject> seen;

  uint32_t pixel(uint32_t lane) const { return lanes_[lane].pixel; }

  const std::vector<SlotColumns>& contributions() const { return contributions_; }
  /// It came by way of mirrors.
  bool mirrored(const SlotColumns& column, uint32_t lane) const;
  /// The share of a slot's light that reaches a lane to which some arrives: without a ray, as the pixel's
  /// others told.
  double visible(const SlotColumns& column, uint32_t lane) const {
    const int32_t ray = column.ray[lane];
    if (ray >= 0) return visible_[size_t(ray)];
    return ray == SlotColumns::kRays ? column.seen[lane] : frame_.of_pixel(pixel(lane))[column.slot].lit;
  }
  /// What a lane's sample sees.
  Vec3d value(uint32_t lane) const;

 private:
  struct Lane {
    uint32_t pixel, index;
    uint64_t frame_pixel;
    bool all;
  };
  struct Batch;
  uint64_t frame_pixel(uint32_t p) const;
  uint32_t make_rays(std::span<const SampleRun> runs);
  void find_points(std::span<const SampleRun> runs);
  void light(std::span<const SampleRun> runs, uint32_t luminaire, const Batch& batch,
             const ShadowOrigins& origins);
  /// What a surface point sends on of a luminaire.
  struct Reflected {
    Vec3d diffuse;                // unshadowed, by the closed form
    double size = 0, weight = 0;  // of all of it and of the sampled point, display units
    bool may_be_glossy = false;
    Vec3d glossy = {};  // unshadowed, of the sampled point
    double glossy_weight = 0;
  };
  Reflected reflected_by_lobes(const LitPoint& lit, const Luminaire& luminaire, double form_factor,
                               const Vec3f& to_light, float sampled) const;
  void light_by_packet(const LitPoint& lit, uint32_t luminaire, double form_factor, float u, float v,
                       uint32_t lane, uint32_t slot);
  void place_on_light(std::span<const SampleRun> runs, uint32_t luminaire, const Batch& batch, float* u,
                      float* v) const;
  bool wants_ray(const Lane& lane, const Slot& slot, uint32_t luminaire) const;
  void add_dropped();
  SlotColumns& columns_of(uint32_t slot);

  const RenderContext& c_;
  const FilteredFrame& frame_;
  RenderTally& tally_;
  double display_scale_, tolerance_;
  uint32_t luminaires_, lobes_;
  ShadowQueue queue_;
  Lane lanes_[kPacket];
  Ray rays_[kPacket];
  std::vector<LitPoint> points_;  // LitPoint::pixel is the lane
  std::vector<SlotColumns> contributions_;
  std::vector<int32_t> column_of_;  // by slot: its number among them
  /// A diffuse lobe's unshadowed light from a luminaire that is too dim for a ray.
  struct Dropped {
    uint32_t point, luminaire;  // of points_
    Vec3d diffuse;
  };
  std::vector<Dropped> dropped_;
  std::vector<uint8_t> visible_;
};

}  // namespace penumbra
