// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/debug_pixel.h"

#include <sstream>

#include "sampling/hash.h"
#include "visibility/shadow_rays.h"

namespace penumbra {
namespace {

std::ostream& operator<<(std::ostream& out, const Vec3d& v) {
  return out << '(' << v.x << ", " << v.y << ", " << v.z << ')';
}

/// '#': seen, '.': hidden, '-': one of the two faces away.
std::string visibility_mask(const RenderContext& c, const Sampler& sampler, const LitPoint& lit,
                            size_t luminaire) {
  alignas(64) float u[kPacket], v[kPacket];
  alignas(64) int traced[kPacket] = {};
  LightPoints points;
  const uint64_t index = lit.stream * c.luminaires.size() + luminaire;
  sampler.points({index, hash_of(index)}, 0, kPacket, u, v);
  c.luminaires[luminaire].evaluate(lit.surface, u, v, kPacket, points);
  std::string mask(kPacket, '-');
  for (uint32_t i = 0; i < kPacket; ++i)
    if (points.form_factor[i] > 0) mask[i] = '.';
  if (c.luminaires[luminaire].casts_shadow())
    ShadowRays(c.geometry, lit.surface, c.luminaires[luminaire].shadow_kind())
        .hide(kPacket, points.x, points.y, points.z, points.form_factor, traced);
  for (uint32_t i = 0; i < kPacket; ++i)
    if (points.form_factor[i] > 0) mask[i] = '#';
  return mask;
}

void tell_luminaires(std::ostream& out, const RenderContext& c, const Sampler& sampler, const LitPoint& lit,
                     const PixelTrace& trace) {
  for (size_t l = 0; l < c.luminaires.size(); ++l) {
    const Luminaire& luminaire = c.luminaires[l];
    out << "    luminaire '" << luminaire.name() << "': form factor without shadows "
        << luminaire.form_factor(lit.surface) << ", 16 points " << visibility_mask(c, sampler, lit, l)
        << '\n';
    bool told = false;
    for (const LightDecision& d : trace.decisions) {
      if (d.bounce != lit.bounce || d.luminaire != l) continue;
      out << "      " << d.decision << ": " << d.points << " points, estimate " << d.estimate << '\n';
      told = true;
    }
    if (!told)
      out << (luminaire.form_factor(lit.surface) > 0 ? "      too dim for a ray, or no power here\n"
                                                     : "      out of sight\n");
  }
}

}  // namespace

std::string debug_pixel(const RenderContext& c, const Rectangle& block, uint32_t x, uint32_t y,
                        void (*film_block)(const RenderContext&, const Rectangle&, RenderTally&)) {
  PixelTrace trace{.x = x, .y = y};
  RenderTally tally;
  tally.light.trace = &trace;
  film_block(c, block, tally);

  std::ostringstream out;
  const Ray ray = c.camera.through(x + 0.5, y + 0.5);
  HitColumns found;
  c.geometry.find_surfaces(&ray, 1, found);
  // BOUNDED's own points; FIXED's come in another order, neighbours first.
  const auto sampler =
      make_sampler({SamplerKind::kOwenSobol, SampleReuse::kScrambled, c.settings.seed, kPacket});
  std::vector<LitPoint> points;
  uint64_t mirror_rays = 0;
  const uint64_t frame_pixel = uint64_t(y) * c.settings.width + x;
  PathEnd end;
  c.paths.follow(found, 0, 0, frame_pixel * c.settings.pixel_samples, points, mirror_rays, end);
  out << pixel_name(x, y, end.first.object) << ", ray through its centre\n";
  const Normalization& n = c.geometry.normalization();
  for (const LitPoint& lit : points) {
    out << "  surface point " << lit.bounce << " at " << n.world_point(lit.surface.position) << ", normal "
        << lit.surface.normal << ", facet " << lit.surface.geometric_normal << ", material '"
        << c.scene.materials()[lit.surface.material].name << "', throughput " << lit.throughput << '\n';
    tell_luminaires(out, c, *sampler, lit, trace);
  }
  const Rectangle& region = c.film.region();
  const size_t at = size_t(y - region.y) * region.width + (x - region.x);
  const float* rgba = &c.film.pass("Combined")[4 * at];
  out << "  Combined " << rgba[0] << ", " << rgba[1] << ", " << rgba[2] << ", alpha " << rgba[3]
      << "; estimated error " << c.film.pass("Error Estimate")[at] << ", tolerance "
      << c.settings.error_tolerance
      << (tally.non_finite_pixels ? "; not finite: " + tally.first_non_finite : "") << '\n';
  return out.str();
}

}  // namespace penumbra
