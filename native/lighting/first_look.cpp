// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/first_look.h"

#include <algorithm>

#include "lighting/light_cut.h"

namespace penumbra {
namespace {

/// Surface points that are looked at together: as many as stay in the first cache; where luminaires are
/// groups with much memory of their own, so many that it is not fetched too often.
constexpr uint32_t kLookedAt = kBatch, kLookedAtByGroups = 16 * kBatch;

}  // namespace

FirstLook::FirstLook(const ItemSampler& sampler, const Block& block, std::span<const Luminaire> luminaires,
                     const std::vector<LitPoint>& points, const BoundedSettings& settings, double drop_share,
                     BlockMemory& memory)
    : sampler_(sampler),
      block_(block),
      luminaires_(luminaires),
      points_(points),
      settings_(settings),
      drop_share_(drop_share),
      batch_(luminaires.size() > kFewLuminaires ? kLookedAtByGroups : kLookedAt),
      dropped_(memory) {}

std::span<const LookedItem> FirstLook::next(bool all_found, LightTally& tally) {
  items_.clear();
  while (items_.empty() && points_.size() - looked_at_ >= (all_found ? 1 : batch_)) {
    const uint32_t begin = looked_at_;
    looked_at_ = find_quads(begin);
    find_items(begin, looked_at_, tally);
    if (luminaires_.size() > 1) drop_dim_items(begin, tally);
    for (size_t first = 0, last; first < items_.size(); first = last) {
      group_.clear();
      for (last = first; last < items_.size() && items_[last].luminaire == items_[first].luminaire; ++last)
        group_.push_back(quad_[items_[last].point - begin]);
      sampler_.look(std::span(items_).subspan(first, last - first), group_, tally);
    }
  }
  return items_;
}

/// Whole quads of 2 x 2 pixels, which share packets, of about batch_ points from `begin` on. A block's first
/// row and column are even in the frame, so that its quads are the frame's. Returns where they end.
uint32_t FirstLook::find_quads(uint32_t begin) {
  quad_.clear();
  place_.clear();
  uint32_t end = begin, whole = begin;
  for (; end < points_.size(); ++end) {
    const uint32_t p = points_[end].pixel, quad = p / block_.width / 2 * block_.width + p % block_.width / 2;
    if (end > begin && quad != quad_.back()) whole = end;
    if (end - begin >= batch_ && whole > begin) return whole;
    place_.push_back(end == begin ? 0 : place_.back() + (p != points_[end - 1].pixel));
    quad_.push_back(quad);
  }
  return end;
}

void FirstLook::find_items(uint32_t begin, uint32_t end, LightTally& tally) {
  for (uint32_t l = 0; l < luminaires_.size(); ++l) {
    for (uint32_t first = begin; first < end; first += kBatch) {
      const uint32_t last = std::min(first + kBatch, end);
      SurfaceColumns columns;
      for (uint32_t p = first; p < last; ++p) columns.add(points_[p].surface);
      alignas(64) double form_factors[kBatch];
      luminaires_[l].form_factors(columns, form_factors);
      for (uint32_t p = first; p < last; ++p) {
        tally.stop_if_cancelled();
        if (form_factors[p - first] <= 0) {
          tally.decided_without_ray += block_.in_core(points_[p].pixel, 0);
          continue;
        }
        const LookedItem item = sampler_.make(p, l, form_factors[p - first]);
        if (item.size() > 0) items_.push_back(item);
      }
    }
  }
}

/// Sets each pixel's dimmest items aside, as many as its share of the tolerance pays for: they get no ray.
void FirstLook::drop_dim_items(uint32_t begin, LightTally& tally) {
  of_pixel_.resize(std::max<size_t>(of_pixel_.size(), place_.back() + 1));
  for (auto& list : of_pixel_) list.clear();
  for (uint32_t i = 0; i < items_.size(); ++i) of_pixel_[place_[items_[i].point - begin]].push_back(i);
  std::vector<uint8_t> dropped(items_.size());
  for (auto& list : of_pixel_) {
    std::sort(list.begin(), list.end(), [this](uint32_t a, uint32_t b) {
      const double size = items_[a].size(), other = items_[b].size();
      return size != other ? size < other : slot(items_[a]) < slot(items_[b]);
    });
    double charge = 0;
    for (uint32_t i : list) {
      charge += items_[i].size() / 2;
      if (charge > drop_share_ * settings_.tolerance) break;
      dropped[i] = 1;
      tally.decided_without_ray += block_.in_core(items_[i].pixel, 0);
      dropped_.push_back(items_[i]);
    }
  }
  size_t kept = 0;
  for (size_t i = 0; i < items_.size(); ++i)
    if (!dropped[i]) items_[kept++] = items_[i];
  items_.resize(kept);
}

}  // namespace penumbra
