// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/filtered_block.h"

#include <algorithm>
#include <cmath>

#include "lighting/spread.h"
#include "render/edge_light.h"

namespace penumbra {
namespace {

constexpr int kGateReach = 2, kFloodReach = 2;

/// Up to such a difference, display units, what a filter's tails see of a surface may be left out (EdgeMap).
constexpr double kMostContrast = 2;

/// Pixels around a block that it looks at: what floods into it can come from so far away. Even: whole quads,
/// whose samples share packets.
uint32_t halo(const PixelFilter& filter) {
  return uint32_t(kFloodReach + std::max(kGateReach, filter.reach() + 1) + 1) / 2 * 2;
}

class FilteredBlock {
 public:
  FilteredBlock(const RenderContext& context, const Rectangle& core, RenderTally& tally);
  void run();

 private:
  std::span<Slot> slots(uint32_t p) { return frame_.of_pixel(p); }
  /// Penumbra on a smooth surface: rays from the centre serve.
  bool is_smooth(uint32_t p) const { return frame_.uncertain[p] && !frame_.edge[p]; }
  /// Penumbra at an edge whose light comes from the centre: they serve, too.
  bool has_penumbra(uint32_t p) const;
  template <typename Function>
  void for_quads(Function function);
  template <typename Function>
  void for_tiles(Function function);
  void first_look();
  void compare(uint32_t p);
  void mark_uncertain(uint32_t p, uint32_t s);
  bool may_show_edge(uint32_t p) const;
  bool is_bent(uint32_t p) const;
  void find_edges();
  void look_at_edges();
  void find_uncertain();
  void flood();
  void start(std::span<const uint32_t> quad, int margin);
  template <typename Condition>
  std::vector<uint32_t> pixels_of(const Rectangle& tile, Condition condition) const;
  PixelLight light(uint32_t p) const;
  void write();
  void tell(PixelTrace& trace);

  const RenderContext& c_;
  RenderTally& tally_;
  Rectangle area_;
  Block block_;
  Reused<FilteredPixel> pixels_;
  FilteredFrame frame_;
  FilteredSamples samples_;
  CentreLight centres_;
  EdgeLight edges_;
};

FilteredBlock::FilteredBlock(const RenderContext& context, const Rectangle& core, RenderTally& tally)
    : c_(context),
      tally_(tally),
      area_(with_halo(core, halo(context.filter), context.settings)),
      block_(block_of(core, area_, context.settings)),
      pixels_(context.memory),
      frame_(make_frame(context, area_, block_)),
      samples_(context, frame_, pixels_, tally),
      centres_(context, block_, frame_, pixels_, tally, samples_.parts()),
      edges_(context, block_, frame_, pixels_, samples_) {
  pixels_.resize(block_.pixels());
  if (tally.light.trace) aim(*tally.light.trace, area_);
}

void FilteredBlock::run() {
  first_look();
  find_uncertain();
  flood();
  for_tiles([this](const Rectangle& tile) {
    centres_.refine(pixels_of(tile, [this](uint32_t p) { return is_smooth(p) || has_penumbra(p); }), tile);
  });
  for (uint32_t p = 0; p < block_.pixels(); ++p)
    if (block_.in_core(p, 0) && has_penumbra(p) && !pixels_[p].bent)
      edges_.set_centre(p, centres_.light(p), centres_.slope(p));
  for_quads([this](std::span<const uint32_t> quad) { edges_.start(quad, 0); });
  for_tiles([this](const Rectangle& tile) {
    edges_.refine(pixels_of(tile, [this](uint32_t p) { return frame_.edge[p]; }), tile);
  });
  write();
  if (PixelTrace* trace = tally_.light.trace) tell(*trace);
}

/// Calls function with the pixels of each 2 x 2 quad of the frame: what shares packets is the same wherever a
/// block begins.
template <typename Function>
void FilteredBlock::for_quads(Function function) {
  for (uint32_t y = area_.y / 2 * 2; y < area_.y + area_.height; y += 2) {
    for (uint32_t x = area_.x / 2 * 2; x < area_.x + area_.width; x += 2) {
      uint32_t quad[4], count = 0;
      for (uint32_t i = 0; i < 4; ++i) {
        const uint32_t bx = x + i % 2 - area_.x, by = y + i / 2 - area_.y;  // wraps below the area
        if (bx < block_.width && by < block_.height) quad[count++] = by * block_.width + bx;
      }
      function(std::span<const uint32_t>(quad, count));
    }
  }
}

/// Calls function with each of the frame's tiles in the core, as pixels of the block.
template <typename Function>
void FilteredBlock::for_tiles(Function function) {
  for (uint32_t y = 0; y < block_.core_height; y += kTile)
    for (uint32_t x = 0; x < block_.core_width; x += kTile)
      function(Rectangle{block_.core_x + x, block_.core_y + y, std::min(kTile, block_.core_width - x),
                         std::min(kTile, block_.core_height - y)});
}

/// Every pixel's centre, and camera rays around it, where that is plain, else four samples. Edges between it
/// and its neighbours are found while those are in the cache.
void FilteredBlock::first_look() {
  for_packets_of_pixels(area_, [this](std::span<const PixelPlace> places) {
    const bool may_be_plain = !c_.pixel_rays.spread();
    if (may_be_plain) centres_.look(places);
    uint32_t pixels[kPacket], count = 0;
    for (const PixelPlace& place : places)
      if (const uint32_t p = pixel_at(place, area_); p != kOutside) pixels[count++] = p;
    const auto is_plain = [this](uint32_t p) { return pixels_[p].plain; };
    const auto may_be_edge = [this](uint32_t p) { return pixels_[p].plain && may_show_edge(p); };
    samples_.look_around({pixels, std::stable_partition(pixels, pixels + count, may_be_edge)});
    samples_.trace_each({std::stable_partition(pixels, pixels + count, is_plain), pixels + count}, 0,
                        kFirstSamples);
    for (uint32_t p : std::span(pixels, count)) compare(p);
    if (may_be_plain) centres_.look_at_lights(false);
  });
  centres_.look_at_lights(true);
}

/// With the pixels left and below, which were looked at before.
void FilteredBlock::compare(uint32_t p) {
  FilteredPixel& pixel = pixels_[p];
  const auto compare_with = [&](uint32_t q, uint8_t side) {
    const FilteredPixel& other = pixels_[q];
    const bool both = pixel.plain && other.plain,
               edge = edge_between(other.first, pixel.first) || (both && pixel.material != other.material);
    if (edge)
      pixel.parted |= side;
    else if (both)
      pixel.joined |= side;
  };
  if (p % block_.width > 0) compare_with(p - 1, kJoinedTo[0]);
  if (p >= block_.width) compare_with(p - block_.width, kJoinedTo[1]);
}

bool FilteredBlock::may_show_edge(uint32_t p) const {
  return !c_.edge_map || c_.edge_map->may_show_edge(area_.x + p % block_.width, area_.y + p / block_.width);
}

/// Unshadowed light at a plain pixel's centre is not what the filter would make of it, as far as its
/// neighbours' on the same surface tell: half the filter's second moment times the second differences; at its
/// border one further in stands for it, or the first one.
bool FilteredBlock::is_bent(uint32_t p) const {
  const uint32_t at[2] = {p % block_.width, p / block_.width}, size[2] = {block_.width, block_.height},
                 stride[2] = {1, block_.width};
  Vec3d sum;
  for (int axis = 0; axis < 2; ++axis) {
    if (size[axis] < 3) continue;
    // Is the pixel d further on the same surface as the one behind it?
    const auto joined = [&](int d) {
      return int(at[axis]) + d > 0 && int(at[axis]) + d < int(size[axis]) &&
             pixels_[p + uint32_t(d) * stride[axis]].joined & kJoinedTo[axis];
    };
    const auto light = [&](int d) { return pixels_[p + uint32_t(d) * stride[axis]].centre_light; };
    const auto bend = [&](int d) { return light(d - 1) - light(d) * 2 + light(d + 1); };
    Vec3d change;
    if (joined(0) && joined(1))
      change = bend(0);
    else if (joined(1))
      change = joined(2) ? bend(1) : light(1) - light(0);
    else if (joined(0))
      change = joined(-1) ? bend(-1) : light(-1) - light(0);
    else
      return !may_show_edge(p);
    sum += absolute(change);
  }
  return 0.5 * c_.filter.variance() * max_component(sum) * std::exp2(c_.settings.exposure) >
         kBendShare * c_.settings.error_tolerance;
}

/// Edges by what the first look found. Where the map tells of them, only pixels that it marks have them, and
/// others where what was found has no edge of a triangle: surfaces that pass through each other, light that
/// bends.
void FilteredBlock::find_edges() {
  std::vector<uint8_t>& edges = frame_.edge;
  std::vector<uint8_t> marked(block_.pixels());
  const double display_scale = std::exp2(c_.settings.exposure);
  const auto note = [&](uint32_t p, uint32_t q) {
    const bool plain = pixels_[p].plain && pixels_[q].plain,
               told = c_.edge_map && plain && (may_show_edge(p) || may_show_edge(q)) &&
                      max_abs(pixels_[p].centre_light - pixels_[q].centre_light) * display_scale <=
                          kMostContrast;
    (told ? marked : edges)[p] = (told ? marked : edges)[q] = 1;
  };
  for (uint32_t p = 0; p < block_.pixels(); ++p) {
    const FilteredPixel& pixel = pixels_[p];
    if (pixel.parted & kJoinedTo[0]) note(p, p - 1);
    if (pixel.parted & kJoinedTo[1]) note(p, p - block_.width);
    if (frame_.uncertain[p]) note(p, p);
    if (c_.pixel_rays.spread() || (pixel.plain && is_bent(p))) edges[p] = 1;
  }
  spread(edges, block_.width, block_.height, c_.filter.reach());
  if (!c_.edge_map) return;
  look_at_edges();
  spread(marked, block_.width, block_.height, c_.filter.reach());
  for (uint32_t p = 0; p < block_.pixels(); ++p) edges[p] |= marked[p] && may_show_edge(p);
}

/// Camera rays around the centres of edges that had none.
void FilteredBlock::look_at_edges() {
  for_quads([this](std::span<const uint32_t> quad) {
    uint32_t late[4], count = 0;
    for (uint32_t p : quad)
      if (frame_.edge[p] && pixels_[p].plain && !may_show_edge(p)) late[count++] = p;
    samples_.look_around({late, count});
    const auto is_plain = [this](uint32_t p) { return pixels_[p].plain; };
    samples_.trace_each({std::stable_partition(late, late + count, is_plain), late + count}, 0,
                        kFirstSamples);
  });
}

void FilteredBlock::find_uncertain() {
  const double display_scale = std::exp2(c_.settings.exposure);
  for (uint32_t p = 0; p < block_.pixels(); ++p)
    if (pixels_[p].plain)
      pixels_[p].slopes = plain_slopes(pixels_, block_.width, p, c_.filter.variance(), display_scale);
  find_edges();
  frame_.uncertain = frame_.edge;
  Reused<uint8_t> flags(c_.memory, block_.pixels()), blind(c_.memory, block_.pixels());

  for (uint32_t s = 0; s < frame_.slot_count; ++s) {
    constexpr uint8_t kLit = 1, kDark = 2;
    for (uint32_t p = 0; p < block_.pixels(); ++p) {
      const Slot& slot = slots(p)[s];
      flags[p] = uint8_t((slot.lit ? kLit : 0) | (slot.dark ? kDark : 0));
      // Most points of the first look lay below the horizon, and yet light arrives.
      blind[p] = 2 * slot.rays < kFirstSamples && max_abs(slot.now.unshadowed) > 0;
    }
    spread(flags, block_.width, block_.height, kGateReach);
    const bool wide = c_.luminaires[s / (frame_.glossy ? 2 : 1) % c_.luminaires.size()].is_wide();
    for (uint32_t p = 0; p < block_.pixels(); ++p)
      if (flags[p] == (kLit | kDark) || (wide && flags[p]) || blind[p]) mark_uncertain(p, s);
  }
}

/// Both lobes of a luminaire; a point light's shadow is an edge.
void FilteredBlock::mark_uncertain(uint32_t p, uint32_t s) {
  const uint32_t lobes = frame_.glossy ? 2 : 1, pair = s / lobes;
  for (uint32_t lobe = 0; lobe < lobes; ++lobe) slots(p)[pair * lobes + lobe].uncertain = true;
  frame_.uncertain[p] = 1;
  if (c_.luminaires[pair % c_.luminaires.size()].is_point()) frame_.edge[p] = 1;
}

/// Where the first points or samples of an uncertain pixel find penumbra, its neighbours may have it too.
void FilteredBlock::flood() {
  for_quads([this](std::span<const uint32_t> quad) { start(quad, kFloodReach); });
  Reused<uint8_t> flags(c_.memory, block_.pixels());
  for (uint32_t s = 0; s < frame_.slot_count; ++s) {
    for (uint32_t p = 0; p < block_.pixels(); ++p)
      flags[p] = frame_.uncertain[p] &&
                 ((pixels_[p].edge && slots(p)[s].lit && slots(p)[s].dark) || centres_.mixed(p, s));
    spread(flags, block_.width, block_.height, kFloodReach);
    for (uint32_t p = 0; p < block_.pixels(); ++p)
      if (flags[p]) mark_uncertain(p, s);
  }
  for_quads([this](std::span<const uint32_t> quad) { start(quad, 0); });
}

/// A quad's uncertain pixels, of those so far from the core at most: rays from the centre where the surface
/// is smooth, else samples.
void FilteredBlock::start(std::span<const uint32_t> quad, int margin) {
  const auto start_centres = [&](auto condition) {
    uint32_t pixels[4], count = 0;
    for (uint32_t p : quad)
      if (condition(p) && block_.in_core(p, margin)) pixels[count++] = p;
    centres_.start({pixels, count});
  };
  start_centres([this](uint32_t p) { return is_smooth(p); });
  edges_.start(quad, margin);
  start_centres([this](uint32_t p) { return has_penumbra(p); });
}

bool FilteredBlock::has_penumbra(uint32_t p) const {
  return frame_.edge[p] && pixels_[p].centred() &&
         std::ranges::any_of(frame_.of_pixel(p), [](const Slot& slot) { return slot.uncertain; });
}

/// The tile's pixels (of the block) for which a condition holds.
template <typename Condition>
std::vector<uint32_t> FilteredBlock::pixels_of(const Rectangle& tile, Condition condition) const {
  std::vector<uint32_t> pixels;
  for (uint32_t y = tile.y; y < tile.y + tile.height; ++y)
    for (uint32_t x = tile.x; x < tile.x + tile.width; ++x)
      if (condition(y * block_.width + x)) pixels.push_back(y * block_.width + x);
  return pixels;
}

/// For --debug-pixel.
void FilteredBlock::tell(PixelTrace& trace) {
  const uint32_t p = trace.pixel;
  const bool smooth = is_smooth(p) || has_penumbra(p);
  if (smooth) centres_.tell(trace);
  penumbra::tell(trace, pixels_[p], slots(p), uint32_t(c_.luminaires.size()), frame_.glossy ? 2 : 1, smooth);
}

/// What a pixel gets in the end.
PixelLight FilteredBlock::light(uint32_t p) const {
  if (frame_.edge[p]) return pixels_[p].light(frame_.of_pixel(p));
  if (frame_.uncertain[p]) return centres_.light(p);
  // A certain pixel: what its first look may have missed, as far as the calibration lets it.
  return {pixels_[p].fitted(frame_.of_pixel(p)), c_.settings.error_tolerance / 2, pixels_[p].light_points};
}

void FilteredBlock::write() {
  const Rectangle& region = c_.film.region();
  for (uint32_t row = 0; row < block_.core_height; ++row) {
    for (uint32_t column = 0; column < block_.core_width; ++column) {
      const uint32_t x = area_.x + block_.core_x + column, y = area_.y + block_.core_y + row;
      if (x - region.x >= region.width || y - region.y >= region.height) continue;
      const uint32_t p = (block_.core_y + row) * block_.width + block_.core_x + column;
      const FilteredPixel& pixel = pixels_[p];
      const PixelLight found = light(p);
      PixelValues values;
      values.combined = found.radiance;
      values.alpha = pixel.opacity();
      values.light_samples = double(found.points);
      values.error_estimate = found.error;
      set_data_passes(values, pixel.first, c_.geometry.normalization());
      tally_.pixels_at_limit += found.at_limit;
      tally_.light.light_points += found.points;
      const bool broken = c_.film.write(x, y, values),
                 extra_broken = samples_.parts() && samples_.parts()->write(p, x, y, pixel, centres_);
      if ((broken || extra_broken) && tally_.non_finite_pixels++ == 0)
        tally_.first_non_finite = pixel_name(x, y, pixel.first.object);
    }
  }
}

}  // namespace

void render_filtered_block(const RenderContext& context, const Rectangle& core, RenderTally& tally) {
  FilteredBlock(context, core, tally).run();
}

}  // namespace penumbra
