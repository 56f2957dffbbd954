// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/filtered_pixel.h"

#include <cmath>

namespace penumbra {
namespace {

/// Neighbours across an edge: their normals differ by more than this, or one lies off the other's plane by
/// more than this share of their distance (a curved surface that passes the first test stays below 0.16).
constexpr float kEdgeCosine = 0.95f;
constexpr double kEdgeSlope = 0.2;

}  // namespace

bool edge_between(const FirstSight& a, const FirstSight& b) {
  if (a.object != b.object || a.lights != b.lights) return true;
  if (!a.hit) return false;
  if (dot(a.normal, b.normal) < kEdgeCosine) return true;
  const Vec3d between = b.position - a.position;
  const double off = dot(between, Vec3d(a.geometric_normal));
  return off * off > kEdgeSlope * kEdgeSlope * dot(between, between);
}

/// The filtered value of a smooth function differs from that at the centre by half the filter's second moment
/// times the second derivatives: by differences along both axes; by the first one next to an edge.
PlainSlopes plain_slopes(std::span<const FilteredPixel> pixels, uint32_t block_width, uint32_t p,
                         double filter_variance, double display_scale) {
  const uint32_t at[2] = {p % block_width, p / block_width},
                 size[2] = {block_width, uint32_t(pixels.size()) / block_width}, stride[2] = {1, block_width};
  double slope = 0;
  Vec3d bends;
  for (int axis = 0; axis < 2; ++axis) {
    if (size[axis] == 1) continue;
    Vec3d before, behind;  // steps
    const bool has_before = at[axis] > 0 && (pixels[p].joined & kJoinedTo[axis]),
               has_behind = at[axis] + 1 < size[axis] && (pixels[p + stride[axis]].joined & kJoinedTo[axis]);
    if (!has_before && !has_behind) return {0, INFINITY};
    if (has_before) before = pixels[p].centre_light - pixels[p - stride[axis]].centre_light;
    if (has_behind) behind = pixels[p + stride[axis]].centre_light - pixels[p].centre_light;
    slope = std::max({slope, max_abs(before), max_abs(behind)});
    const Vec3d bend = behind - before;
    bends += absolute(bend);
  }
  return {float(slope * display_scale), float(0.5 * filter_variance * max_component(bends) * display_scale)};
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
  Vec3d sum;
  if (count > 0) {
    sum = background / count;
    for (const Slot& slot : slots) sum += slot.radiance(slot.now, count);
  }
  return edge ? sum + edge->sights.correction(count).value : sum;
}

double FilteredPixel::opacity() const {
  const double mean = count > 0 || !edge ? alpha / samples() : 0;
  return edge ? std::clamp(mean + edge->sights.correction(count).alpha, 0.0, 1.0) : mean;
}

Vec3d FilteredPixel::unshadowed(std::span<const Slot> slots) const {
  Vec3d sum = background;
  for (const Slot& slot : slots) sum += slot.now.unshadowed;
  return sum / samples();
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
                               slot.radiance(slot.now, pixel.samples())});
  }
}

}  // namespace penumbra
