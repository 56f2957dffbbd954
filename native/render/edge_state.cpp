// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/edge_state.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "render/filtered_pixel.h"

namespace penumbra {
namespace {

/// What may hide in a pixel where all samples agree with all neighbours, as a share of the light there:
/// shadows so thin that none met them.
constexpr double kUnseenShadow = 0.25;

/// Of luminaires mostly below the horizon: only samples of what is above tell how much of it is seen.
double blind_variance(uint32_t count, std::span<const Slot> slots, const ErrorModel& model) {
  double sum = 0;
  for (const Slot& slot : slots) {
    if (!slot.uncertain || slot.rays == 0 || 2 * slot.rays >= count) continue;
    const double size = max_abs(slot.now.unshadowed) / count * model.display_scale;
    sum += size * size * 0.25 * std::pow(double(count) / slot.rays, 2 * model.light_exponent());
  }
  return sum;
}

/// Luminaires that no sample could look at: all of their light.
double unknown_variance(uint32_t count, std::span<const Slot> slots, double display_scale) {
  double sum = 0;
  for (const Slot& slot : slots) {
    if (!slot.uncertain || slot.rays > 0) continue;
    const double size = max_abs(slot.now.unshadowed) / count * display_scale;
    sum += size * size;
  }
  return sum;
}

}  // namespace

LevelSums::LevelSums(const FilteredPixel& pixel, std::span<const Slot> slot_sums)
    : background(pixel.background), alpha(pixel.alpha) {
  for (const Slot& slot : slot_sums) slots.push_back(slot.now);
}

void EdgeState::close_level(const FilteredPixel& pixel, std::span<const Slot> slots,
                            const ErrorModel& model) {
  if (sights.has_new_rays()) close_rays(pixel, slots, model);
  if (pixel.count > closed) close_samples(pixel, slots, model);
  unknown = (pixel.count > 0 ? unknown_variance(pixel.count, slots, model.display_scale) : 0) +
            sights.mean_variance(pixel.count, slope);
}

void EdgeState::close_rays(const FilteredPixel& pixel, std::span<const Slot> slots, const ErrorModel& model) {
  const double n = sights.rays();
  // As if one more ray had seen the opposite: rays that agree are no proof.
  const double opposite = max_abs(pixel.unshadowed(slots)) * model.display_scale;
  shares.fall = std::pow(n, -2 * model.share_exponent());
  shares.expected = sights.spread_between(model.display_scale) + opposite * opposite / n;
  shares.by_blocks =
      sights.close_rays(model.display_scale, model.dimensions - kLightDimensions) / shares.fall;
}

void EdgeState::close_samples(const FilteredPixel& pixel, std::span<const Slot> slots,
                              const ErrorModel& model) {
  closed = pixel.count;
  const double n = pixel.count;
  // As above, of rays to luminaires.
  double opposite = 0;
  for (const Slot& slot : slots)
    opposite += max_abs(slot.now.unshadowed) / n * model.display_scale *
                (slot.split       ? 1.0 / kPacket
                 : slot.uncertain ? 1
                                  : kUnseenShadow);
  light.fall = std::pow(n, -2 * model.light_exponent());
  light.expected =
      std::max(sights.spread_within() + opposite * opposite / n, blind_variance(pixel.count, slots, model));
  light.by_blocks = variance_of_level(pixel, slots, model) / light.fall;
}

/// From the sums at the ends of the level's blocks, as LevelCounts::in_block() has them.
double EdgeState::variance_of_level(const FilteredPixel& pixel, std::span<const Slot> slots,
                                    const ErrorModel& model) {
  const bool power_of_two = std::has_single_bit(pixel.count);
  const int blocks = power_of_two ? 2 : 3;
  const double size = double(pixel.count) / blocks;
  LevelSums now(pixel, slots);
  const LevelSums* ends[4] = {nullptr, power_of_two ? &power : &half, power_of_two ? &now : &power, &now};
  Vec3d values[3];
  double alphas[3];
  for (int b = 0; b < blocks; ++b) {
    const LevelSums *begin = ends[b], &end = *ends[b + 1];
    const Appearance expected = sights.block(&SeenSurface::samples, b, power_of_two, size);
    values[b] = (begin ? end.background - begin->background : end.background) / size - expected.value;
    alphas[b] = (begin ? end.alpha - begin->alpha : end.alpha) / size - expected.alpha;
    for (size_t s = 0; s < slots.size(); ++s)
      values[b] += slots[s].radiance(begin ? end.slots[s] - begin->slots[s] : end.slots[s], size);
  }
  if (power_of_two) {
    half = std::move(power);
    power = std::move(now);
    sights.mark_samples();
  }
  return variance_of_blocks({values, size_t(blocks)}, {alphas, size_t(blocks)}, model.display_scale,
                            model.dimensions);
}

}  // namespace penumbra
