// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/filtered_pixel.h"

#include <cmath>

namespace penumbra {
namespace {

/// Neighbours across an edge: their normals differ by more than this, or one lies off the other's plane by
/// more than this share of their distance (a curved surface that passes the first test stays below 0.16).
constexpr float kEdgeCosine = 0.95f;
constexpr double kEdgeSlope = 0.2;

/// What may hide in a pixel where all samples agree with all neighbours, as a share of the light there:
/// shadows so thin that none met them.
constexpr double kUnseenShadow = 0.25;

}  // namespace

bool edge_between(const FirstSight& a, const FirstSight& b) {
  if (a.object != b.object || a.lights != b.lights) return true;
  if (!a.hit) return false;
  if (dot(a.normal, b.normal) < kEdgeCosine) return true;
  const Vec3d between = b.position - a.position;
  const double off = dot(between, Vec3d(a.geometric_normal));
  return off * off > kEdgeSlope * kEdgeSlope * dot(between, between);
}

PlaneFit::PlaneFit(const double* px, const double* py) {
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (uint32_t i = 0; i < kFirstSamples; ++i) {
    x += px[i], y += py[i];
    xx += px[i] * px[i], xy += px[i] * py[i], yy += py[i] * py[i];
  }
  // First column of the adjugate of the normal equations [4 x y; x xx xy; y xy yy].
  const Vec3d c{xx * yy - xy * xy, xy * y - x * yy, x * xy - xx * y};
  const double determinant = kFirstSamples * c.x + x * c.y + y * c.z;
  const bool flat =
      determinant < 0.05;  // of a pixel's units to the fourth: a triple of points nearly on a line
  for (uint32_t i = 0; i < kFirstSamples; ++i)
    h[i] = flat ? 0.25 : (c.x + c.y * px[i] + c.z * py[i]) / determinant;
  // The residual of four points lies in one direction, the one all planes are orthogonal to: signed areas.
  const auto area = [&](int a, int b, int d) {
    return (px[b] - px[a]) * (py[d] - py[a]) - (px[d] - px[a]) * (py[b] - py[a]);
  };
  r = {area(1, 2, 3), -area(0, 2, 3), area(0, 1, 3), -area(0, 1, 2)};
  const double size = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
  for (double& value : r) value = size > 0 ? value / size : 0;
}

Vec3d FilteredPixel::estimate(std::span<const Slot> slots) const {
  Vec3d sum = background / count;
  for (const Slot& slot : slots) sum += slot.radiance(slot.now, count);
  return sights ? sum + sights->correction(count) : sum;
}

double FilteredPixel::opacity() const {
  const double mean = alpha / count;
  return sights ? std::clamp(mean + sights->alpha_correction(count), 0.0, 1.0) : mean;
}

Vec3d FilteredPixel::unshadowed(std::span<const Slot> slots) const {
  Vec3d sum = background;
  for (const Slot& slot : slots) sum += slot.now.unshadowed;
  return sum / count;
}

Vec3d same_side(const Vec3d& plane, const Vec3d& samples) {
  return {plane.x * samples.x > 0 ? plane.x : 0, plane.y * samples.y > 0 ? plane.y : 0,
          plane.z * samples.z > 0 ? plane.z : 0};
}

Vec3d FilteredPixel::fitted(std::span<const Slot> slots) const {
  Vec3d sum = same_side(background_fitted, background);
  for (const Slot& slot : slots)
    if (!slot.uncertain) sum += same_side(slot.fitted_radiance(), slot.now.unshadowed);
  return sum;
}

void tell(PixelTrace& trace, const FilteredPixel& pixel, std::span<const Slot> slots, uint32_t luminaires,
          uint32_t lobes, bool smooth) {
  for (uint32_t s = 0; s < slots.size(); ++s) {
    const Slot& slot = slots[s];
    if (slot.now.unshadowed == Vec3d{} || (smooth && slot.uncertain)) continue;
    const char* decision = slot.uncertain ? "may be in penumbra" : slot.lit ? "wholly seen" : "wholly hidden";
    trace.decisions.push_back({s / lobes / luminaires, s / lobes % luminaires, decision, pixel.count,
                               slot.radiance(slot.now, pixel.count)});
  }
}

/// Of luminaires mostly below the horizon: only samples of what is above tell how much of it is seen.
double FilteredPixel::blind_variance(std::span<const Slot> slots, const ErrorModel& model) const {
  double sum = 0;
  for (const Slot& slot : slots) {
    if (!slot.uncertain || slot.rays == 0 || 2 * slot.rays >= count) continue;
    const double size = max_abs(slot.now.unshadowed) / count * model.display_scale;
    sum += size * size * 0.25 * std::pow(double(count) / slot.rays, 2 * model.light_exponent());
  }
  return sum;
}

/// Luminaires that no sample could look at, all of their light; and surfaces that few samples met.
double FilteredPixel::unknown(std::span<const Slot> slots, double display_scale) const {
  double sum = 0;
  for (const Slot& slot : slots) {
    if (!slot.uncertain || slot.rays > 0) continue;
    const double size = max_abs(slot.now.unshadowed) / count * display_scale;
    sum += size * size;
  }
  return sum + sights->mean_variance(count);
}

void FilteredPixel::remember_power(std::span<const Slot> slots) {
  if (!history) history = std::make_unique<History>();
  LevelSums& power = history->power;
  power.background = background;
  power.alpha = alpha;
  power.slots.clear();
  for (const Slot& slot : slots) power.slots.push_back(slot.now);
}

void FilteredPixel::close_level(std::span<const Slot> slots, const ErrorModel& model) {
  if (sights->has_new_rays()) close_rays(slots, model);
  if (count > closed) close_samples(slots, model);
  unknown_variance = unknown(slots, model.display_scale);
}

void FilteredPixel::close_rays(std::span<const Slot> slots, const ErrorModel& model) {
  const double n = sights->rays();
  // As if one more ray had seen the opposite: rays that agree are no proof.
  const double opposite = max_abs(unshadowed(slots)) * model.display_scale;
  shares.fall = std::pow(n, -2 * model.share_exponent());
  shares.expected = sights->spread_between(model.display_scale) + opposite * opposite / n;
  shares.by_blocks =
      sights->close_rays(model.display_scale, model.dimensions - kLightDimensions) / shares.fall;
}

void FilteredPixel::close_samples(std::span<const Slot> slots, const ErrorModel& model) {
  closed = count;
  const double n = count;
  // As above, of rays to luminaires.
  double opposite = 0;
  for (const Slot& slot : slots)
    opposite += max_abs(slot.now.unshadowed) / n * model.display_scale *
                (slot.split       ? 1.0 / kPacket
                 : slot.uncertain ? 1
                                  : kUnseenShadow);
  light_variance.fall = std::pow(n, -2 * model.light_exponent());
  light_variance.expected =
      std::max(sights->spread_within() + opposite * opposite / n, blind_variance(slots, model));
  light_variance.by_blocks = variance_of_level(slots, model) / light_variance.fall;
}

double FilteredPixel::variance_of_level(std::span<const Slot> slots, const ErrorModel& model) {
  const LevelSums &half = history->half, &power = history->power;
  const bool power_of_two = (count & (count - 1)) == 0;
  const int blocks = power_of_two ? 2 : 3;
  const double size = double(count) / blocks;
  Vec3d values[3];
  double alphas[3];
  if (power_of_two) {
    alphas[0] = power.alpha;
    alphas[1] = alpha - power.alpha;
    values[0] = power.background / size;
    values[1] = (background - power.background) / size;
  } else {
    alphas[0] = half.alpha;
    alphas[1] = power.alpha - half.alpha;
    alphas[2] = alpha - power.alpha;
    values[0] = half.background / size;
    values[1] = (power.background - half.background) / size;
    values[2] = (background - power.background) / size;
  }
  for (size_t s = 0; s < slots.size(); ++s) {
    const Slot& slot = slots[s];
    if (power_of_two) {
      values[0] += slot.radiance(power.slots[s], size);
      values[1] += slot.radiance(slot.now - power.slots[s], size);
    } else {
      values[0] += slot.radiance(half.slots[s], size);
      values[1] += slot.radiance(power.slots[s] - half.slots[s], size);
      values[2] += slot.radiance(slot.now - power.slots[s], size);
    }
  }
  for (int b = 0; b < blocks; ++b) {
    values[b] = values[b] - sights->block_value(&SeenSurface::samples, b, power_of_two, size);
    alphas[b] = alphas[b] / size - sights->block_alpha(&SeenSurface::samples, b, power_of_two, size);
  }
  if (power_of_two) {
    std::swap(history->half, history->power);
    remember_power(slots);
  }
  const double variance = variance_of_blocks({values, size_t(blocks)}, {alphas, size_t(blocks)},
                                             model.display_scale, model.dimensions);
  if (power_of_two) sights->mark_samples();
  return variance;
}

}  // namespace penumbra
