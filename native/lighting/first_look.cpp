// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/first_look.h"

#include <algorithm>

#include "lighting/light_cut.h"
#include "math/simd.h"

namespace penumbra {
namespace {

/// Surface points that are looked at together: as many as stay in the first cache; where luminaires are
/// groups with much memory of their own, so many that it is not fetched too often.
constexpr uint32_t kLookedAt = kBatch, kLookedAtByGroups = 4 * kBatch;

}  // namespace

FirstLook::FirstLook(const ItemSampler& sampler, const Block& block, std::span<const Luminaire> luminaires,
                     const std::vector<LitPoint>& points, const BoundedSettings& settings, double drop_share,
                     BlockMemory& memory, double dim_size)
    : sampler_(sampler),
      block_(block),
      luminaires_(luminaires),
      points_(points),
      settings_(settings),
      drop_share_(drop_share),
      dim_size_(dim_size),
      batch_(luminaires.size() > kFewLuminaires ? kLookedAtByGroups : kLookedAt),
      chunks_(memory),
      form_factors_(memory),
      sizes_(memory),
      items_(memory),
      dropped_(memory) {}

std::span<const LookedItem> FirstLook::next(bool all_found, LightTally& tally) {
  items_.clear();
  while (items_.empty() && points_.size() - looked_at_ >= (all_found ? 1 : batch_)) {
    const uint32_t begin = looked_at_;
    looked_at_ = find_quads(begin);
    fill_chunks(begin, looked_at_);
    find_sizes(begin, tally);
    if (luminaires_.size() > 1) drop_dim_items(begin, looked_at_, tally);
    make_items(begin, looked_at_);
    for (size_t first = 0, last; first < items_.size(); first = last) {
      group_.clear();
      const LookedItem& one = items_[first];
      for (last = first;
           last < items_.size() && items_[last].luminaire == one.luminaire && items_[last].looks == one.looks;
           ++last)
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
  uint32_t end = begin, whole = begin;
  for (; end < points_.size(); ++end) {
    const uint32_t p = points_[end].pixel, quad = p / block_.width / 2 * block_.width + p % block_.width / 2;
    if (end > begin && quad != quad_.back()) whole = end;
    if (end - begin >= batch_ && whole > begin) return whole;
    quad_.push_back(quad);
  }
  return end;
}

void FirstLook::fill_chunks(uint32_t begin, uint32_t end) {
  chunks_.resize((end - begin + kBatch - 1) / kBatch);
  for (Chunk& chunk : chunks_) {
    chunk.surfaces.count = 0;
    chunk.any_other_lobes = false;
    for (uint32_t i = 0; i < kBatch && begin < end; ++i, ++begin) {
      const LitPoint& lit = points_[begin];
      chunk.surfaces.add(lit.surface);
      for (int c = 0; c < 3; ++c) {
        chunk.throughput[c][i] = lit.throughput[c];
        chunk.albedo[c][i] = lit.material->diffuse[c];
      }
      chunk.in_core[i] = block_.in_core(lit.pixel, 0);
      chunk.other_lobes[i] = lit.material->has_diffuse_lobes || lit.material->has_glossy();
      chunk.any_other_lobes |= chunk.other_lobes[i];
    }
  }
}

/// As LookedItem::size() of Lambert's lobe.
PENUMBRA_VECTORIZED
void FirstLook::light_sizes(const Chunk& chunk, const Vec3d& radiance, double display_scale,
                            const double* form_factors, double* sizes) {
  const Vec3d r = radiance;
  const uint32_t count = chunk.surfaces.count;
  double out[kBatch];
  for (size_t i = 0; i < count; ++i) {
    const double f = form_factors[i];
    const double x = std::abs(chunk.throughput[0][i] * r.x * chunk.albedo[0][i] * f),
                 y = std::abs(chunk.throughput[1][i] * r.y * chunk.albedo[1][i] * f),
                 z = std::abs(chunk.throughput[2][i] * r.z * chunk.albedo[2][i] * f);
    const double yz = y < z ? z : y, size = (x < yz ? yz : x) * display_scale;
    out[i] = f > 0 && size > 0 ? size : 0.0;
  }
  for (size_t i = 0; i < count; ++i) sizes[i] = out[i];
}

void FirstLook::find_sizes(uint32_t begin, LightTally& tally) {
  form_factors_.resize(entry_of(chunks_.size(), 0));
  sizes_.resize(form_factors_.size());
  by_other_lobes_.clear();
  for (uint32_t l = 0; l < luminaires_.size(); ++l) {
    const Luminaire& luminaire = luminaires_[l];
    for (size_t c = 0; c < chunks_.size(); ++c) {
      tally.stop_if_cancelled();
      const Chunk& chunk = chunks_[c];
      const size_t entry = entry_of(c, l);
      double *form_factors = &form_factors_[entry], *sizes = &sizes_[entry];
      luminaire.form_factors(chunk.surfaces, form_factors);
      light_sizes(chunk, luminaire.role().diffuse ? luminaire.radiance() : Vec3d{}, settings_.display_scale,
                  form_factors, sizes);
      for (uint32_t i = 0; i < chunk.surfaces.count; ++i)
        tally.decided_without_ray += chunk.in_core[i] && form_factors[i] <= 0;
      if (!chunk.any_other_lobes) continue;
      by_other_lobes_at_.resize(sizes_.size());
      for (uint32_t i = 0; i < chunk.surfaces.count; ++i) {
        if (!chunk.other_lobes[i]) continue;
        sizes[i] = 0;
        if (!(form_factors[i] > 0)) continue;
        tally.stop_if_cancelled();
        const LookedItem made = sampler_.make(begin + uint32_t(c) * kBatch + i, l, form_factors[i]);
        if (!(made.size() > 0)) continue;
        sizes[i] = made.size();
        by_other_lobes_at_[entry + i] = uint32_t(by_other_lobes_.size());
        by_other_lobes_.push_back(made);
      }
    }
  }
}

/// Sets each pixel's dimmest items aside, as many as its share of the tolerance pays for: they get no ray.
void FirstLook::drop_dim_items(uint32_t begin, uint32_t end, LightTally& tally) {
  const double budget = drop_share_ * settings_.tolerance;
  for (uint32_t first = begin, last; first < end; first = last) {
    candidates_.clear();
    for (last = first; last < end && points_[last].pixel == points_[first].pixel; ++last) {
      const double* size = &sizes_[entry_of_point(last - begin, 0)];
      for (uint32_t l = 0; l < luminaires_.size(); ++l, size += kBatch)
        if (*size > 0 && *size / 2 <= budget) candidates_.push_back({*size, last, l});
    }
    std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
      if (a.size != b.size) return a.size < b.size;
      return a.point != b.point ? a.point < b.point : a.luminaire < b.luminaire;
    });
    double charge = 0;
    for (const Candidate& candidate : candidates_) {
      charge += candidate.size / 2;
      if (charge > budget) break;
      const uint32_t at = candidate.point - begin;
      const size_t entry = entry_of_point(at, candidate.luminaire);
      dropped_.push_back(item(candidate.point, candidate.luminaire, entry));
      sizes_[entry] = 0;
      tally.decided_without_ray += chunks_[at / kBatch].in_core[at % kBatch];
    }
  }
}

/// For each point that has an item, by the largest of its quad: those share packets.
void FirstLook::choose_looks(uint32_t count, uint32_t luminaire) {
  looks_.resize(count);
  const bool all = luminaires_[luminaire].is_wide();
  for (uint32_t first = 0, last; first < count; first = last) {
    double largest = 0;
    for (last = first; last < count && quad_[last] == quad_[first]; ++last)
      largest = std::max(largest, sizes_[entry_of_point(last, luminaire)]);
    const uint32_t looks = all || largest > 2 * dim_size_ ? kFirstLook : largest > dim_size_ ? 2 : 1;
    for (uint32_t i = first; i < last; ++i)
      looks_[i] = sizes_[entry_of_point(i, luminaire)] > 0 ? uint8_t(looks) : 0;
  }
}

void FirstLook::make_items(uint32_t begin, uint32_t end) {
  for (uint32_t l = 0; l < luminaires_.size(); ++l) {
    choose_looks(end - begin, l);
    for (uint8_t looks = 1; looks <= kFirstLook; looks *= 2)
      for (uint32_t i = 0; i < end - begin; ++i) {
        if (looks_[i] != looks) continue;
        items_.push_back(item(begin + i, l, entry_of_point(i, l)));
        items_.back().looks = looks;
      }
  }
}

LookedItem FirstLook::item(uint32_t point, uint32_t luminaire, size_t entry) const {
  const LitPoint& lit = points_[point];
  if (lit.material->has_diffuse_lobes || lit.material->has_glossy())
    return by_other_lobes_[by_other_lobes_at_[entry]];
  LookedItem item;
  item.point = point;
  item.pixel = lit.pixel;
  item.luminaire = luminaire;
  item.diffuse =
      lit.throughput * luminaires_[luminaire].radiance() * lit.material->diffuse * form_factors_[entry];
  item.diffuse_size = sizes_[entry];
  return item;
}

}  // namespace penumbra
