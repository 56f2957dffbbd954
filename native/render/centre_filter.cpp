// SPDX-License-Identifier: GPL-3.0-or-later
// Light at the centres of smooth pixels becomes that of the filtered ones.
#include <algorithm>
#include <cmath>

#include "lighting/pooled_error.h"
#include "render/centre_light.h"
#include "render/filtered_parts.h"

namespace penumbra {
namespace {

/// Share of the tolerance that taking the centre for the filtered pixel may cost.
constexpr double kFilterShare = 0.3;

/// What the standard errors of values make of that of their second and fourth difference: sqrt(6), sqrt(70);
/// and of a second and a third together, at most.
constexpr double kSecondNoise = 2.45, kFourthNoise = 8.37, kThirdNoise = kSecondNoise + 4.47;

/// Of 16 points, as a share of the unshadowed value: 16^-3/4 / 2. So many of them, and of those of refined
/// values, are no sign of light that bends.
constexpr double kFirstError = 0.0625, kFirstErrors = 3, kLastErrors = 1;

/// Filters up to this variance are taken from three pixels along an axis: the weight of the centre stays
/// above a half.
constexpr double kNarrow = 0.25;

}  // namespace

/// All of one luminaire's light in one bounce, as far as it is known.
LobeLight CentreLight::light_of(uint32_t p, uint32_t pair) const {
  if (const uint32_t i = item_of(p, pair); i != kNone) return {items_[i].radiance(), items_[i].unshadowed()};
  LobeLight sum;
  for (uint32_t lobe = 0; lobe < lobes_; ++lobe) {
    const Slot& slot = frame_.of_pixel(p)[pair * lobes_ + lobe];
    sum.seen += slot.fitted_radiance();
    sum.unshadowed += slot.fitted;
  }
  return sum;
}

/// By what the share that is seen of a luminaire's light differs in the neighbours that count: unshadowed
/// light is the centre's here as everywhere.
Vec3d CentreLight::filter_change(uint32_t p, uint32_t pair) const {
  Vec3d change;
  if (axes_.empty() || !axes_[p]) return change;
  const LobeLight here = light_of(p, pair);
  const double all = max_abs(here.unshadowed), share = all > 0 ? max_abs(here.seen) / all : 0;
  for (int axis = 0; axis < 2; ++axis) {
    const uint32_t stride = axis == 0 ? 1 : block_.width;
    if (!(axes_[p] >> axis & 1)) continue;
    for (const uint32_t q : {p - stride, p + stride}) {
      const LobeLight there = light_of(q, pair);
      change += (there.seen - there.unshadowed * share) * weight_;
    }
  }
  return change;
}

/// Its filter lies on one surface of constant colour.
bool CentreLight::may_be_filtered(uint32_t p) const {
  return pixels_[p].plain && !frame_.edge[p] && c_.filter.variance() <= kNarrow;
}

double CentreLight::noise_of(uint32_t p, uint32_t pair, bool first) const {
  const uint32_t i = item_of(p, pair);
  if (i == kNone) return 0;
  if (first) return kFirstErrors * kFirstError * items_[i].size();
  const double told = light_[p].error / (kItemCalibration.report * light_[p].noise_share),
               most = settings_.tolerance / kItemCalibration.stop;
  return kLastErrors * std::min(told, most) / std::sqrt(double(pairs_));
}

/// The axes along which both neighbours' light is known well enough: the filtered value is the centre's plus
/// half the filter's variance times the second differences, exact for cubic light; its noise is less than the
/// centre's.
void CentreLight::set_filter(uint32_t p, const Rectangle& tile) {
  if (!may_be_filtered(p)) return;
  const uint32_t at[2] = {p % block_.width - tile.x, p / block_.width - tile.y},
                 size[2] = {tile.width, tile.height}, stride[2] = {1, block_.width};
  int count = 0;
  for (int axis = 0; axis < 2; ++axis) {
    if (at[axis] == 0 || at[axis] + 1 == size[axis]) continue;
    const uint32_t before = p - stride[axis], behind = p + stride[axis];
    bool tell = continues(before, axis) && continues(p, axis);
    for (uint32_t pair = 0; tell && pair < pairs_; ++pair)
      tell = !uncertain(p, pair) || (tells(before, pair) && tells(behind, pair));
    if (!tell) continue;
    axes_[p] |= uint8_t(1 << axis);
    ++count;
  }
  const double centre = 1 - 2 * count * weight_;
  light_[p].noise_share = std::sqrt(centre * centre + 2 * count * weight_ * weight_);
}

/// Display value of one luminaire's light in one bounce; of an edge with samples theirs, by which shadows
/// next to it are found.
double CentreLight::value(uint32_t p, uint32_t pair) const {
  const uint32_t i = item_of(p, pair);
  if (i != kNone) return items_[i].display(items_[i].sums);
  double sum = 0;
  for (uint32_t lobe = 0; lobe < lobes_; ++lobe) {
    const Slot& slot = frame_.of_pixel(p)[pair * lobes_ + lobe];
    sum += max_abs(slot.uncertain ? slot.radiance(slot.now, pixels_[p].samples()) : slot.fitted_radiance());
  }
  return sum * settings_.display_scale;
}

double CentreLight::slope(uint32_t p) const {
  double slope = -1;
  const auto sum = [this](uint32_t q) {
    double all = 0;
    for (uint32_t pair = 0; pair < pairs_; ++pair) all += value(q, pair);
    return all;
  };
  const auto knows_all = [this](uint32_t q) {
    for (uint32_t pair = 0; pair < pairs_; ++pair)
      if (!knows(q, pair)) return false;
    return true;
  };
  const double here = sum(p);
  const uint32_t at[2] = {frame_.area.x + p % block_.width, frame_.area.y + p / block_.width};
  for (int axis = 0; axis < 2; ++axis) {
    const uint32_t stride = axis == 0 ? 1 : block_.width;
    if (at[axis] % kTile > 0 && continues(p - stride, axis) && knows_all(p - stride))
      slope = std::max(slope, std::abs(sum(p - stride) - here));
    if ((at[axis] + 1) % kTile > 0 && p + stride < block_.pixels() && continues(p, axis) &&
        knows_all(p + stride))
      slope = std::max(slope, std::abs(sum(p + stride) - here));
  }
  return slope < 0 ? here : slope;
}

/// Of a pixel's centre, or of a plain pixel by samples.
bool CentreLight::knows(uint32_t p, uint32_t pair) const {
  if (!pixels_[p].plain) return !frame_.edge[p];
  return !uncertain(p, pair) || item_of(p, pair) != kNone || pixels_[p].count > 0;
}

/// It is known without noise, or within the tolerance.
bool CentreLight::tells(uint32_t p, uint32_t pair) const {
  return knows(p, pair) && (item_of(p, pair) == kNone ? !uncertain(p, pair) : refined_[p]);
}

/// The next pixel along an axis shows the same surface.
bool CentreLight::continues(uint32_t p, int axis) const {
  const uint32_t q = p + (axis == 0 ? 1 : block_.width);
  if (pixels_[p].plain && pixels_[q].plain) return pixels_[q].joined & kJoinedTo[axis];
  return !frame_.edge[p] && !frame_.edge[q];
}

/// How far the filtered value may be from what is taken for it: half the filter's variance times the second
/// differences along rows and columns, for whole pixels of the tile; at its edge the one further in and its
/// change stand for it; where too few neighbours are known, first differences do. Where neighbours' light
/// counts, what is left of a kink: of a change of slope s the filter makes s times half its mean distance,
/// the neighbours s times half its variance. Half of the difference is taken, as above it is of a kink; the
/// fourth difference, which is 2 s there and next to nothing where light only bends, tells s. noise: so much
/// may be in a value that is not certain.
double CentreLight::filter_error(uint32_t p, uint32_t pair, const Rectangle& tile, double noise) const {
  const uint32_t at[2] = {p % block_.width - tile.x, p / block_.width - tile.y},
                 size[2] = {tile.width, tile.height}, stride[2] = {1, block_.width};
  const double here = value(p, pair);
  const bool filtered = may_be_filtered(p);
  double sum = 0;
  for (int axis = 0; axis < 2; ++axis) {
    // Values from two pixels before to three behind, on the same surface; those outside the tile are not
    // known.
    const auto known = [&](int d) {
      const int i = int(at[axis]) + d;
      if (i < 0 || i >= int(size[axis])) return false;
      for (int k = std::min(d, 0); k < std::max(d, 0); ++k)
        if (!continues(p + uint32_t(k) * stride[axis], axis)) return false;
      const uint32_t q = p + uint32_t(d) * stride[axis];
      return knows(q, pair);
    };
    const auto at_distance = [&](int d) { return value(p + uint32_t(d) * stride[axis], pair); };
    const auto bend = [&](int d) { return at_distance(d - 1) - 2 * at_distance(d) + at_distance(d + 1); };
    if (known(-1) && known(1) && filtered && known(-2) && known(2)) {
      const double fourth = bend(-1) - 2 * bend(0) + bend(1);
      sum += kink_share_ / 2 * std::max(std::abs(fourth) - kFourthNoise * noise, 0.0);
    } else if (known(-1) && known(1)) {
      sum += (filtered ? kink_share_ : 1) * std::max(std::abs(bend(0)) - kSecondNoise * noise, 0.0);
    } else if (known(1) && known(2) && known(3)) {
      sum += std::max(std::abs(bend(1)) + std::abs(bend(2) - bend(1)) - kThirdNoise * noise, 0.0);
    } else if (known(-1) && known(-2) && known(-3)) {
      sum += std::max(std::abs(bend(-1)) + std::abs(bend(-2) - bend(-1)) - kThirdNoise * noise, 0.0);
    } else if (known(1) || known(-1)) {
      const double step = std::abs(at_distance(known(1) ? 1 : -1) - here);
      sum += std::max(2 * step, settings_.tolerance);
    } else {
      return size[axis] == 1 ? 0 : 1e30;  // a picture of one line
    }
  }
  return weight_ * sum;
}

/// Keeps the pixels whose filtered value is their centre's, and makes edges of the others.
std::vector<uint32_t> CentreLight::keep_smooth(std::span<const uint32_t> pixels, const Rectangle& tile,
                                               bool first) {
  std::vector<uint32_t> kept, bent;
  for (uint32_t p : pixels) {
    double error = 0, reported = 0;
    for (uint32_t pair = 0; pair < pairs_; ++pair) {
      if (!uncertain(p, pair)) continue;
      error += filter_error(p, pair, tile, noise_of(p, pair, first));
      if (!first) reported += filter_error(p, pair, tile, 0);
    }
    (error > kFilterShare * settings_.tolerance ? bent : kept).push_back(p);
    if (!first) light_[p].error = std::hypot(light_[p].error, reported);
  }
  for (uint32_t p : bent) frame_.edge[p] = pixels_[p].bent = true;
  return kept;
}

void CentreLight::refine(std::span<const uint32_t> pixels, const Rectangle& tile) {
  if (pixels.empty()) return;
  light_.resize(block_.pixels());
  refined_.resize(block_.pixels());
  axes_.resize(block_.pixels());
  const std::vector<uint32_t> smooth = keep_smooth(pixels, tile, true);
  for (uint32_t p : smooth) refined_[p] = 1;
  std::vector<BoundedItem*> items;
  for (uint32_t p : smooth) {
    const FilteredPixel& pixel = pixels_[p];
    light_[p] = {};
    light_[p].radiance = pixel.fitted(frame_.of_pixel(p));
    light_[p].error =
        pixel.charged / pixel.samples() + (pixel.centred() ? kKeptForSights * settings_.tolerance : 0);
    light_[p].points = pixel.light_points;
    set_filter(p, tile);
    for (uint32_t pair = 0; pair < pairs_; ++pair)
      if (item_of(p, pair) != kNone) items.push_back(&items_[item_of(p, pair)]);
  }
  TileRefiner(sampler_, points_, block_, settings_).refine(items, light_, tally_.light);
  for (const BoundedItem* item : items) light_[points_[item->point].pixel].points += item->used();
  for (uint32_t p : smooth)
    for (uint32_t pair = 0; pair < pairs_; ++pair)
      if (uncertain(p, pair)) light_[p].radiance += filter_change(p, pair);
  keep_smooth(smooth, tile, false);
}

}  // namespace penumbra
