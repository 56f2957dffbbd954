// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/filtered_parts.h"

#include <algorithm>
#include <optional>

namespace penumbra {

FilteredParts::FilteredParts(const RenderContext& context, const FilteredFrame& frame, uint32_t pixels)
    : c_(context),
      frame_(frame),
      sums_(context.extras.want_parts() ? pixels : 0, context.extras.light_groups()),
      fitted_(context.extras.want_parts() ? pixels : 0, context.extras.light_groups()),
      seen_(pixels) {
  if (c_.extras.want_parts() && c_.scene.has_mirrors()) mirrored_.resize(frame.slots.size());
  if (c_.extras.want_mattes()) mattes_.resize(pixels);
}

PathRecord FilteredParts::record_of_centre(uint32_t p) {
  PathRecord record{.mist = &c_.settings.mist, .seen = &seen_[p]};
  if (c_.extras.want_parts()) record.parts = sums_.of(p);
  if (!mattes_.empty()) record.mattes = &mattes_[p];
  return record;
}

std::span<Vec3d> FilteredParts::of_centre(uint32_t p) {
  return c_.extras.want_parts() ? sums_.of(p) : std::span<Vec3d>{};
}

void FilteredParts::begin(uint32_t p) {
  if (c_.extras.want_parts()) std::ranges::fill(sums_.of(p), Vec3d{});
  if (!mattes_.empty()) mattes_[p].clear();
  if (!mirrored_.empty())
    std::fill_n(mirrored_.begin() + ptrdiff_t(p) * frame_.slot_count, frame_.slot_count, Vec3d{});
}

void FilteredParts::add(const SamplePacket& packet, std::span<const SampleRun> runs) {
  uint32_t lane = 0;
  for (const SampleRun& run : runs) {
    std::optional<PlaneFit> fit;
    if (run.first == 0) {
      fit.emplace(packet.dx + lane, packet.dy + lane);
      seen_[run.pixel] = packet.seen[lane];
    }
    for (uint32_t i = 0; i < run.count; ++i, ++lane) {
      if (packet.parts) {
        const auto one = packet.parts->of(lane);
        const auto sums = sums_.of(run.pixel), fitted = fitted_.of(run.pixel);
        for (uint32_t k = 0; k < sums_.count(); ++k) {
          sums[k] += one[k];
          if (fit) fitted[k] += one[k] * fit->h[i];
        }
      }
      if (mattes_.empty()) continue;
      for (const MatteHit& hit : packet.mattes[lane]) add_matte(mattes_[run.pixel], hit);
    }
  }
  if (mirrored_.empty()) return;
  for (const SlotColumns& column : packet.contributions())
    for (uint32_t i = 0; i < lane; ++i)
      if (column.arrives(i) && packet.mirrored(column, i))
        mirrored_[size_t(packet.pixel(i)) * frame_.slot_count + column.slot] += column.unshadowed.get(i);
}

void FilteredParts::add_value(SeenSurface& surface, const SamplePacket& packet, uint32_t lane) const {
  if (!surface.extras) surface.extras = std::make_unique<SurfaceExtras>();
  if (packet.mattes.size() && surface.valued == 1) surface.extras->mattes = packet.mattes[lane];
  if (!packet.parts) return;
  const auto one = packet.parts->of(lane);
  std::vector<Vec3d>& parts = surface.extras->parts;
  parts.resize(one.size());
  for (size_t k = 0; k < one.size(); ++k) parts[k] += one[k];
  const uint32_t lobes = frame_.glossy ? 2 : 1;
  for (const SlotColumns& column : packet.contributions()) {
    if (!column.arrives(lane)) continue;
    const Vec3d light = column.unshadowed.get(lane);
    const double m = packet.mirrored(column, lane) ? 1 : 0;
    add_light(parts, c_.luminaires[column.slot / lobes % c_.luminaires.size()],
              column.slot % lobes ? kGlossyLight : kDiffuseLight,
              {light * packet.visible(column, lane), light}, {m, m, m});
  }
}

/// As FilteredBlock::write() has them for Combined.
std::vector<Vec3d> FilteredParts::parts_of(uint32_t p, const FilteredPixel& pixel,
                                           const CentreLight& centres) const {
  const auto sums = sums_.of(p), fitted = fitted_.of(p);
  const bool sampled = frame_.edge[p] && !pixel.centred();
  std::vector<Vec3d> parts(sums_.count());
  for (uint32_t k = 0; k < parts.size(); ++k)
    parts[k] = sampled ? sums[k] / pixel.count : pixel.count == 0 ? sums[k] : same_side(fitted[k], sums[k]);
  add_slots(p, pixel, sampled, parts);
  if (frame_.uncertain[p] && !sampled) centres.add_parts(p, parts);
  if (!frame_.edge[p]) return parts;
  const PixelSights& sights = pixel.edge->sights;
  if (!sampled)
    for (Vec3d& part : parts) part = part * pixel.edge->centre_share();
  for (const SeenSurface& surface : sights.surfaces()) {
    if (!surface.extras || (!sampled && pixel.edge->is_of_centre(surface))) continue;
    const double weight = sights.weight(surface, pixel.count) / surface.valued;
    for (uint32_t k = 0; k < surface.extras->parts.size(); ++k) parts[k] += surface.extras->parts[k] * weight;
  }
  return parts;
}

/// Adds the light of the slots, but of those that centres know.
void FilteredParts::add_slots(uint32_t p, const FilteredPixel& pixel, bool sampled,
                              std::span<Vec3d> parts) const {
  const auto slots = frame_.of_pixel(p);
  const uint32_t lobes = frame_.glossy ? 2 : 1;
  for (uint32_t s = 0; s < slots.size(); ++s) {
    const Slot& slot = slots[s];
    const Vec3d& all = slot.now.unshadowed;
    if (all == Vec3d{} || (!sampled && slot.uncertain)) continue;
    const LobeLight light =
        sampled ? LobeLight{slot.radiance(slot.now, pixel.count), all / pixel.count}
                : LobeLight{same_side(slot.fitted_radiance(), all), same_side(slot.fitted, all)};
    Vec3d mirrored;
    if (!mirrored_.empty()) {
      const Vec3d& by_mirrors = mirrored_[size_t(p) * frame_.slot_count + s];
      const auto share = [](double some, double whole) { return whole != 0 ? some / whole : 0.0; };
      mirrored = {share(by_mirrors.x, all.x), share(by_mirrors.y, all.y), share(by_mirrors.z, all.z)};
    }
    add_light(parts, c_.luminaires[s / lobes % c_.luminaires.size()],
              s % lobes ? kGlossyLight : kDiffuseLight, light, mirrored);
  }
}

/// Of an edge without samples, what its surfaces show, each as much as its share.
std::vector<MatteHit> FilteredParts::mattes_of(uint32_t p, const FilteredPixel& pixel) const {
  if (!pixel.centred()) return mattes_[p];
  std::vector<MatteHit> mattes;
  for (const SeenSurface& surface : pixel.edge->sights.surfaces()) {
    const bool of_centre = pixel.edge->is_of_centre(surface);
    if (!of_centre && !surface.extras) continue;
    for (MatteHit hit : of_centre ? mattes_[p] : surface.extras->mattes) {
      hit.weight *= pixel.edge->sights.share(surface);
      add_matte(mattes, hit);
    }
  }
  return mattes;
}

bool FilteredParts::write(uint32_t p, uint32_t x, uint32_t y, const FilteredPixel& pixel,
                          const CentreLight& centres) const {
  PixelParts all{.parts = {}, .mattes = {}, .samples = pixel.samples()};
  std::vector<Vec3d> parts;
  std::vector<MatteHit> mattes;
  if (c_.extras.want_parts()) parts = parts_of(p, pixel, centres);
  all.parts = parts;
  if (!mattes_.empty()) mattes = mattes_of(p, pixel);
  all.mattes = mattes;
  return c_.extras.write(x, y, seen_[p], all);
}

}  // namespace penumbra
