// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/filtered_block.h"

#include <algorithm>
#include <cmath>

#include "lighting/bounded_item.h"
#include "lighting/spread.h"
#include "render/filtered_pixel.h"
#include "sampling/hash.h"
#include "visibility/shadow_rays.h"

namespace penumbra {
namespace {

constexpr int kGateReach = 2, kFloodReach = 2, kPool = 2;
static_assert(kGateReach + kFloodReach == int(kFilteredHalo));

/// Quantiles as in BoundedCalibration; smoothed standard error c s n^-0.65 of samples with standard deviation
/// s (between n^-5/8, of an edge in four dimensions, and n^-3/4, in two), worth so many neighbours.
constexpr double kStop = 2.7, kReport = 2.2, kSmoothed = 1.0, kExponent = 0.65, kPriorWeight = 6.0;

/// More rays where first samples' unshadowed values leave a plane by more than this share of the tolerance.
constexpr double kResidualShare = 0.7;
/// Share of the tolerance that dim luminaires may be charged for being left out of the ray count.
constexpr double kDropShare = 0.125;

class FilteredBlock {
 public:
  FilteredBlock(const RenderContext& context, const Rectangle& core, RenderTally& tally);
  void run();

 private:
  uint64_t frame_pixel(uint32_t p) const {
    return uint64_t(area_.y + p / block_.width) * c_.settings.width + area_.x + p % block_.width;
  }
  std::span<Slot> slots(uint32_t p) { return {slots_.data() + size_t(p) * slot_count_, slot_count_}; }
  bool in_core(uint32_t p, int margin) const;
  void first_look();
  void trace(std::span<const uint32_t> pixels, uint32_t first, uint32_t count);
  void find_contributions(uint32_t p, uint32_t first, std::span<PathEnd> ends);
  void light(uint32_t p, uint32_t first, std::span<PathEnd> ends);
  void fit_plane(FilteredPixel& pixel, std::span<Slot> slot, const double* dx, const double* dy,
                 std::span<const PathEnd> ends);
  void mark_uncertain(uint32_t p, uint32_t s);
  void mark_unseen(uint32_t p);
  void find_uncertain();
  void flood();
  void advance(uint32_t p);
  void refine_tile(uint32_t tile_x, uint32_t tile_y);
  double standard_error(uint32_t p, std::span<const uint32_t> uncertain) const;
  void write();

  const RenderContext& c_;
  RenderTally& tally_;
  Rectangle area_;
  Block block_;
  double display_scale_, tolerance_;
  bool phong_ = false;
  uint32_t slot_count_;
  std::vector<FilteredPixel> pixels_;
  std::vector<Slot> slots_;  // by pixel

  // Of the samples of one pixel that are being traced.
  struct Contribution {
    uint32_t sample, slot;
    Vec3d unshadowed;
    double weight;  // of the sampled point, display units
    int64_t ray;    // index into visible_; kNoRay: the slot is certain
  };
  static constexpr int64_t kNoRay = -1;
  std::vector<LitPoint> points_;
  std::vector<uint32_t> sample_of_point_;
  std::vector<Contribution> contributions_;
  std::vector<uint8_t> visible_;
};

FilteredBlock::FilteredBlock(const RenderContext& context, const Rectangle& core, RenderTally& tally)
    : c_(context),
      tally_(tally),
      area_(with_halo(core, kFilteredHalo, context.settings)),
      block_(block_of(core, area_, context.settings)),
      display_scale_(std::exp2(context.settings.exposure)),
      tolerance_(context.settings.error_tolerance) {
  for (const Material& material : c_.scene.materials()) phong_ = phong_ || max_component(material.phong) > 0;
  slot_count_ = uint32_t(c_.luminaires.size()) * c_.paths.length() * (phong_ ? 2 : 1);
  pixels_.resize(block_.pixels());
  slots_.resize(size_t(block_.pixels()) * slot_count_);
  if (tally.light.trace) aim(*tally.light.trace, area_);
}

bool FilteredBlock::in_core(uint32_t p, int margin) const {
  const int x = int(p % block_.width) - int(block_.core_x), y = int(p / block_.width) - int(block_.core_y);
  return x >= -margin && y >= -margin && x < int(block_.core_width) + margin &&
         y < int(block_.core_height) + margin;
}

void FilteredBlock::run() {
  first_look();
  find_uncertain();
  flood();
  for (uint32_t y = 0; y < block_.core_height; y += kTile)
    for (uint32_t x = 0; x < block_.core_width; x += kTile) refine_tile(block_.core_x + x, block_.core_y + y);
  write();
  if (PixelTrace* trace = tally_.light.trace)
    tell(*trace, pixels_[trace->pixel], slots(trace->pixel), uint32_t(c_.luminaires.size()), phong_ ? 2 : 1);
}

/// Four samples of every pixel; 2x2 pixels of the frame a packet, wherever the block begins.
void FilteredBlock::first_look() {
  for (uint32_t y = area_.y / 2 * 2; y < area_.y + area_.height; y += 2) {
    for (uint32_t x = area_.x / 2 * 2; x < area_.x + area_.width; x += 2) {
      std::vector<uint32_t> quad;
      for (uint32_t i = 0; i < 4; ++i) {
        const uint32_t bx = x + i % 2 - area_.x, by = y + i / 2 - area_.y;  // wraps below the area
        if (bx < block_.width && by < block_.height) quad.push_back(by * block_.width + bx);
      }
      trace(quad, 0, kFirstSamples);
    }
  }
}

/// Samples [first, first + count) of some pixels, at most kPacket in all.
void FilteredBlock::trace(std::span<const uint32_t> pixels, uint32_t first, uint32_t count) {
  Ray rays[kPacket];
  Hit hits[kPacket];
  double dx[kPacket], dy[kPacket];
  uint32_t active = 0;
  for (uint32_t k = 0; k < pixels.size(); ++k) {
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t lane = k * count + i, p = pixels[k];
      const UnitPoint u = c_.pixel_light_sampler.pixel(frame_pixel(p), first + i);
      dx[lane] = c_.filter.offset(u.u), dy[lane] = c_.filter.offset(u.v);
      rays[lane] = c_.camera.through(area_.x + p % block_.width + 0.5 + dx[lane],
                                     area_.y + p / block_.width + 0.5 + dy[lane]);
      active |= 1u << lane;
    }
  }
  c_.geometry.intersect(rays, active, hits);
  tally_.primary_rays += pixels.size() * count;
  for (uint32_t k = 0; k < pixels.size(); ++k) {
    const uint32_t p = pixels[k], lane = k * count;
    PathEnd ends[kPacket];
    points_.clear();
    sample_of_point_.clear();
    for (uint32_t i = 0; i < count; ++i) {
      ends[i] = c_.paths.follow(rays[lane + i], hits[lane + i], p, 0, points_, tally_.mirror_rays);
      sample_of_point_.resize(points_.size(), i);
    }
    light(p, first, {ends, count});
    if (first == 0) fit_plane(pixels_[p], slots(p), dx + lane, dy + lane, {ends, count});
  }
}

/// Finds what each traced sample gets from each luminaire, and traces the shadow rays that are wanted.
void FilteredBlock::find_contributions(uint32_t p, uint32_t first, std::span<PathEnd> ends) {
  const std::span<Slot> slot = slots(p);
  const auto luminaires = uint32_t(c_.luminaires.size()), lobes = phong_ ? 2u : 1u;
  contributions_.clear();
  visible_.clear();
  visible_.reserve(points_.size() * luminaires);  // the queue points into it
  ShadowQueue rays(c_.geometry);
  std::vector<double> charge(ends.size(), 0.0);
  for (size_t k = 0; k < points_.size(); ++k) {
    const LitPoint& lit = points_[k];
    const uint32_t sample = sample_of_point_[k];
    const bool has_phong = phong_ && max_abs(lit.material->phong) > 0;
    for (uint32_t l = 0; l < luminaires; ++l) {
      const Luminaire& luminaire = c_.luminaires[l];
      const double form_factor = luminaire.form_factor(lit.surface);
      if (form_factor <= 0) {
        ++tally_.light.decided_without_ray;
        continue;
      }
      const uint32_t s = (lit.bounce * luminaires + l) * lobes;
      const Vec3d arriving = lit.throughput * luminaire.radiance();
      const Vec3d diffuse = arriving * lit.material->diffuse * form_factor;
      const double size = max_abs(diffuse) * display_scale_;
      // Too dim for a ray: half of it is added, and half of it is the error at most.
      if (luminaires > 1 && !has_phong && charge[sample] + size / 2 <= kDropShare * tolerance_) {
        charge[sample] += size / 2;
        ++tally_.light.decided_without_ray;
        ends[sample].background += diffuse * 0.5;
        continue;
      }
      const UnitPoint u = c_.pixel_light_sampler.light(hash_of(frame_pixel(p), s), first + sample);
      LightPoints point;
      luminaire.evaluate(lit.surface, &u.u, &u.v, 1, point);
      const bool wanted = first == 0 || slot[s].uncertain || (phong_ && slot[s + 1].uncertain);
      int64_t ray = kNoRay;
      if (wanted && point.form_factor[0] > 0) {
        ray = int64_t(visible_.size());
        visible_.push_back(1);
        if (luminaire.casts_shadow())
          rays.add(lit.surface, {point.x[0], point.y[0], point.z[0]}, visible_.back());
      }
      if (size > 0)
        contributions_.push_back(
            {sample, s, diffuse, size * double(point.form_factor[0]) / form_factor, ray});
      if (has_phong) {
        // No closed form: the sampled value itself stands for the unshadowed one.
        float lobe;
        evaluate_phong(ShadingPoint(lit.surface, *lit.material, lit.ray_direction), point.x, point.y, point.z,
                       point.form_factor, 1, &lobe);
        const Vec3d specular = arriving * lit.material->phong * double(lobe);
        if (lobe > 0)
          contributions_.push_back({sample, s + 1, specular, max_abs(specular) * display_scale_, ray});
      }
    }
  }
  rays.flush();
  tally_.light.shadow_rays += rays.traced();
  for (double c : charge) pixels_[p].charged += c;
}

/// Adds the light of one pixel's traced samples to its sums.
void FilteredBlock::light(uint32_t p, uint32_t first, std::span<PathEnd> ends) {
  find_contributions(p, first, ends);
  FilteredPixel& pixel = pixels_[p];
  if (first == 0) pixel.first = ends[0];
  std::vector<Vec3d> value(ends.size());
  for (size_t i = 0; i < ends.size(); ++i) {
    value[i] = ends[i].background;
    pixel.background += ends[i].background;
    pixel.alpha += ends[i].alpha;
  }
  for (const Contribution& one : contributions_) {
    Slot& slot = slots(p)[one.slot];
    const bool seen = one.ray == kNoRay ? slot.lit : visible_[size_t(one.ray)];
    slot.now.unshadowed += one.unshadowed;
    if (seen) value[one.sample] += one.unshadowed;
    if (one.ray == kNoRay) continue;
    slot.now.w += one.weight;
    slot.now.wv += seen ? one.weight : 0.0;
    (seen ? slot.lit : slot.dark) = true;
  }
  pixel.light_points += visible_.size();
  for (const Vec3d& v : value) {
    const double x = max_component(v) * display_scale_;
    pixel.x += x;
    pixel.xx += x * x;
  }
  pixel.count = first + uint32_t(ends.size());
}

/// The first samples' plane: unshadowed values at the pixel's centre, and how far they are from it.
void FilteredBlock::fit_plane(FilteredPixel& pixel, std::span<Slot> slot, const double* dx, const double* dy,
                              std::span<const PathEnd> ends) {
  const PlaneFit fit({dx[0], dx[1], dx[2], dx[3]}, {dy[0], dy[1], dy[2], dy[3]});
  Vec3d residual;
  for (uint32_t i = 0; i < kFirstSamples; ++i) {
    pixel.background_fitted += ends[i].background * fit.h[i];
    residual += ends[i].background * fit.r[i];
    pixel.uncertain = pixel.uncertain || ends[i].object != ends[0].object;
  }
  for (const Contribution& one : contributions_) {
    slot[one.slot].fitted += one.unshadowed * fit.h[one.sample];
    residual += one.unshadowed * fit.r[one.sample];
  }
  pixel.residual = max_abs(residual) * display_scale_;
  pixel.uncertain = pixel.uncertain || pixel.residual > kResidualShare * tolerance_;
}

void FilteredBlock::find_uncertain() {
  // Edges reach into the pixels next to those that saw them, since the filter does.
  std::vector<uint8_t> flags(block_.pixels());
  for (uint32_t p = 0; p < block_.pixels(); ++p) {
    const uint32_t x = p % block_.width, y = p / block_.width;
    bool edge = pixels_[p].uncertain;
    if (x + 1 < block_.width) edge = edge || edge_between(pixels_[p], pixels_[p + 1]);
    if (y + 1 < block_.height) edge = edge || edge_between(pixels_[p], pixels_[p + block_.width]);
    flags[p] = edge;
  }
  spread(flags, block_.width, block_.height, 1);
  for (uint32_t p = 0; p < block_.pixels(); ++p) pixels_[p].uncertain = flags[p];

  for (uint32_t s = 0; s < slot_count_; ++s) {
    constexpr uint8_t kLit = 1, kDark = 2;
    for (uint32_t p = 0; p < block_.pixels(); ++p)
      flags[p] = uint8_t((slots(p)[s].lit ? kLit : 0) | (slots(p)[s].dark ? kDark : 0));
    spread(flags, block_.width, block_.height, kGateReach);
    const bool wide = c_.luminaires[s / (phong_ ? 2 : 1) % c_.luminaires.size()].is_wide();
    for (uint32_t p = 0; p < block_.pixels(); ++p)
      if (flags[p] == (kLit | kDark) || (wide && flags[p])) mark_uncertain(p, s);
  }
  for (uint32_t p = 0; p < block_.pixels(); ++p) mark_unseen(p);
}

void FilteredBlock::mark_uncertain(uint32_t p, uint32_t s) {
  slots(p)[s].uncertain = true;
  pixels_[p].uncertain = true;
}

/// A pixel that gets more samples may see luminaires that its first ones did not face.
void FilteredBlock::mark_unseen(uint32_t p) {
  if (!pixels_[p].uncertain) return;
  for (Slot& slot : slots(p)) slot.uncertain = slot.uncertain || (!slot.lit && !slot.dark);
}

/// Where 16 samples of an uncertain pixel find penumbra, its neighbours may have it too.
void FilteredBlock::flood() {
  for (uint32_t p = 0; p < block_.pixels(); ++p)
    if (pixels_[p].uncertain && in_core(p, kFloodReach)) advance(p);
  std::vector<uint8_t> flags(block_.pixels());
  for (uint32_t s = 0; s < slot_count_; ++s) {
    for (uint32_t p = 0; p < block_.pixels(); ++p)
      flags[p] = pixels_[p].count > kFirstSamples && slots(p)[s].lit && slots(p)[s].dark;
    spread(flags, block_.width, block_.height, kFloodReach);
    for (uint32_t p = 0; p < block_.pixels(); ++p)
      if (flags[p]) mark_uncertain(p, s);
  }
  for (uint32_t p = 0; p < block_.pixels(); ++p) mark_unseen(p);
}

/// One level more for a pixel.
void FilteredBlock::advance(uint32_t p) {
  FilteredPixel& pixel = pixels_[p];
  const uint32_t target = next_level(pixel.count);
  while (pixel.count < target) {
    const uint32_t step = pixel.count < kPacket ? (pixel.count < 8 ? 8 - pixel.count : 8) : kPacket;
    trace({&p, 1}, pixel.count, step);
    if (pixel.count != 8) continue;
    pixel.background_power = pixel.background;
    pixel.alpha_power = pixel.alpha;
    for (Slot& slot : slots(p)) slot.power = slot.now;
  }
  pixel.close_level(slots(p), display_scale_);
}

/// Of the pixel's estimate, with its uncertain neighbours' help.
double FilteredBlock::standard_error(uint32_t p, std::span<const uint32_t> uncertain) const {
  const FilteredPixel& pixel = pixels_[p];
  const double n = pixel.count;
  const std::span<const Slot> slot{slots_.data() + size_t(p) * slot_count_, slot_count_};
  const double prior = kSmoothed * kSmoothed * pixel.prior_variance(slot, display_scale_, kExponent);
  const int x = int(p % block_.width), y = int(p / block_.width);
  double sum = 0;
  int count = 0;
  for (uint32_t q : uncertain) {
    const int dx = int(q % block_.width) - x, dy = int(q / block_.width) - y;
    if (std::abs(dx) > kPool || std::abs(dy) > kPool) continue;
    sum += pixels_[q].variance * std::pow(pixels_[q].count / n, 2 * kExponent);
    ++count;
  }
  return std::sqrt((kPriorWeight * prior + sum) / (kPriorWeight + count));
}

void FilteredBlock::refine_tile(uint32_t tile_x, uint32_t tile_y) {
  std::vector<uint32_t> uncertain, open;
  const uint32_t right = std::min(tile_x + kTile, block_.core_x + block_.core_width);
  const uint32_t top = std::min(tile_y + kTile, block_.core_y + block_.core_height);
  for (uint32_t y = tile_y; y < top; ++y)
    for (uint32_t x = tile_x; x < right; ++x)
      if (pixels_[y * block_.width + x].uncertain) uncertain.push_back(y * block_.width + x);
  for (uint32_t p : uncertain)
    if (pixels_[p].count < kPacket) advance(p);
  for (open = uncertain; !open.empty();) {
    std::vector<uint32_t> again;
    for (uint32_t p : open) {
      FilteredPixel& pixel = pixels_[p];
      const double error = standard_error(p, uncertain), charged = pixel.charged / pixel.count;
      const double tolerance =
          tolerance_ * std::max(1.0, max_component(pixel.estimate(slots(p))) * display_scale_);
      pixel.error = kReport * error + charged;
      if (kStop * error + charged <= tolerance) continue;
      pixel.at_limit = next_level(pixel.count) > c_.settings.max_pixel_samples;
      if (!pixel.at_limit) again.push_back(p);
    }
    for (uint32_t p : again) advance(p);
    open = std::move(again);
  }
}

void FilteredBlock::write() {
  const Rectangle& region = c_.film.region();
  for (uint32_t p = 0; p < block_.pixels(); ++p) {
    const uint32_t x = area_.x + p % block_.width, y = area_.y + p / block_.width;
    if (!in_core(p, 0) || x - region.x >= region.width || y - region.y >= region.height) continue;
    const FilteredPixel& pixel = pixels_[p];
    PixelValues values;
    values.combined = pixel.uncertain ? pixel.estimate(slots(p)) : pixel.fitted(slots(p));
    values.alpha = pixel.alpha / pixel.count;
    values.light_samples = double(pixel.light_points);
    // A certain pixel: what its first look may have missed, as far as the calibration lets it.
    values.error_estimate = pixel.uncertain ? pixel.error : tolerance_ / 2;
    set_data_passes(values, pixel.first, c_.geometry.normalization());
    tally_.pixels_at_limit += pixel.at_limit;
    tally_.light.light_points += pixel.light_points;
    if (c_.film.write(x, y, values) && tally_.non_finite_pixels++ == 0)
      tally_.first_non_finite = pixel_name(x, y, pixel.first.object);
  }
}

}  // namespace

void render_filtered_block(const RenderContext& context, const Rectangle& core, RenderTally& tally) {
  FilteredBlock(context, core, tally).run();
}

}  // namespace penumbra
