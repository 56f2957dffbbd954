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
};

/// What one sample gets from one slot.
struct Contribution {
  uint32_t lane, slot;
  Vec3d unshadowed;
  double weight;  // of the sampled point on the luminaire, display units
  int64_t ray;    // number among the packet's shadow rays; kNoRay: none was wanted
};
inline constexpr int64_t kNoRay = -1;

/// Where the pixels of a block are, and their slots.
struct FilteredFrame {
  Rectangle area;  // of the block with its halo, full-frame pixels
  uint32_t block_width;
  bool glossy;  // some material has such a lobe: two slots for each luminaire and bounce
  uint32_t slot_count;
  std::vector<Slot> slots;         // by pixel
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

  // Of the last packet, by lane:
  double dx[kPacket], dy[kPacket];  // place, pixels from the pixel's centre
  PathEnd ends[kPacket];
  double charge[kPacket];     // error of dim luminaires that were left out, display units
  uint32_t rays_of[kPacket];  // shadow rays
  // Only where passes want them:
  std::optional<LightParts> parts;  // of all but the contributions
  std::vector<std::vector<MatteHit>> mattes;
  std::vector<SeenObject> seen;

  uint32_t pixel(uint32_t lane) const { return lanes_[lane].pixel; }

  const std::vector<Contribution>& contributions() const { return contributions_; }
  /// It came by way of mirrors.
  bool mirrored(const Contribution& one) const;
  bool sees(const Contribution& one) const { return visible_[size_t(one.ray)]; }

 private:
  struct Lane {
    uint32_t pixel, index;
    uint64_t frame_pixel;
  };
  uint64_t frame_pixel(uint32_t p) const;
  void find_points(std::span<const SampleRun> runs);
  void light(std::span<const SampleRun> runs, uint32_t luminaire, uint32_t begin, uint32_t end,
             const SurfaceColumns& columns);
  void place_on_light(std::span<const SampleRun> runs, uint32_t luminaire, uint32_t begin, uint32_t end,
                      float* u, float* v) const;
  bool wants_ray(const Lane& lane, const Slot& slot, uint32_t luminaire) const;
  void add_dropped();
  int64_t add_ray(const LitPoint& lit, const Luminaire& luminaire, const Vec3f& to_light);

  const RenderContext& c_;
  const FilteredFrame& frame_;
  RenderTally& tally_;
  double display_scale_, tolerance_;
  uint32_t luminaires_, lobes_;
  ShadowQueue queue_;
  Lane lanes_[kPacket];
  std::vector<LitPoint> points_;  // LitPoint::pixel is the lane
  std::vector<Contribution> contributions_;
  /// A diffuse lobe's unshadowed light from a luminaire that is too dim for a ray.
  struct Dropped {
    uint32_t point, luminaire;  // of points_
    Vec3d diffuse;
  };
  std::vector<Dropped> dropped_;
  std::vector<uint8_t> visible_;
};

}  // namespace penumbra
