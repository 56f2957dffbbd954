// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/paths.h"

#include <cmath>

namespace penumbra {
namespace {

/// Transparent surfaces that a path may pass, and those of them whose own light it gathers.
constexpr uint32_t kMaxPassed = 256, kMaxLitPassed = 7;
/// A surface is what the data passes show if it hides more than this (Cycles' alpha threshold).
constexpr double kSeenOpacity = 0.5;
/// Share of the light below which a path ends: far below a display's steps.
constexpr double kNegligible = 1e-5;
/// Where surfaces both reflect and let through, a path becomes a tree without end: that share doubles every
/// so many rays, until after 17 times as many it is 1, and the path ends. Guarded by test_d_paths.py.
constexpr uint32_t kRaysPerDoubling = 1024, kMostRays = 17 * kRaysPerDoubling;

double average(const Vec3d& c) {
  return (c.x + c.y + c.z) / 3;
}

/// What the camera sees of a surface that is held out: nothing but what is behind it.
std::shared_ptr<const Closures> hole_of(const Closures& closures) {
  auto hole = std::make_shared<Closures>();
  hole->transparency = closures.transparency;
  hole->holdout = std::max(1 - average(closures.transparency), 0.0);
  return hole;
}

std::vector<Luminaire> seen_luminaires(const Scene& scene, const Normalization& normalization) {
  std::vector<Luminaire> luminaires;
  for (size_t i = 0; i < scene.luminaires().size(); ++i) {
    const LuminaireDescription& description = scene.luminaires()[i];
    const LuminaireRole& role =
        std::visit([](const auto& d) -> const LuminaireRole& { return d.role; }, description);
    if (role.to_camera || role.in_mirrors)
      luminaires.emplace_back(description, normalization, scene.light_group_of(i));
  }
  return luminaires;
}

}  // namespace

/// A stretch of a path, between mirrors and transparent surfaces.
struct PathTracer::Part {
  Part(const Ray& r, const Hit& h, double f)
      : ray(r), hit(h), footprint(f) {}  // as an aggregate: zeroed first

  Ray ray;
  Hit hit;
  Vec3d throughput{1, 1, 1};
  uint32_t mirrors = 0, passed = 0;
  double t = 0, footprint;  // at the ray's start

  bool from_camera() const { return mirrors == 0; }
};

PathTracer::PathTracer(const Scene& scene, const Geometry& geometry, const Materials& materials,
                       const RenderSettings& settings)
    : scene_(scene),
      geometry_(geometry),
      materials_(materials),
      seen_(seen_luminaires(scene, geometry.normalization())),
      mirror_depth_(scene.has_mirrors() ? settings.mirror_depth : 0),
      length_(mirror_depth_ + 1 + (scene.has_transparency() ? kMaxLitPassed : 0)),
      perspective_(scene.camera().kind == CameraKind::kPerspective),
      scale_(geometry.normalization().scale),
      pixel_(std::abs(scene.camera().window.right - scene.camera().window.left) / settings.width) {
  for (const Material& m : scene.materials())
    ends_paths_.push_back(!m.program && m.emission == Vec3d{} && m.mirror == Vec3d{} &&
                          m.transparency == Vec3d{} && m.holdout == 0);
}

/// What a part sees that meets nothing.
void PathTracer::leave(const Part& part, PathEnd& end, const PathRecord* record) const {
  const Background& background = scene_.background();
  if (record && (background.seen_by_camera || !part.from_camera()))
    record->leave(part.throughput * background.radiance(part.ray.direction), part.mirrors,
                  background.light_group, !part.from_camera() || !background.transparent);
  if (part.from_camera() && background.transparent)
    end.alpha -= average(part.throughput);
  else if (background.seen_by_camera || !part.from_camera())
    end.background += part.throughput * background.radiance(part.ray.direction);
}

/// Luminaires that a part sees on its way up to t_far, which may be infinity. As in Cycles they hide nothing,
/// neither what is behind them nor the film.
void PathTracer::see_luminaires(const Ray& ray, double t_far, bool blocked, const Vec3d& throughput,
                                uint32_t mirrors, PathEnd& end, const PathRecord* record) const {
  const SightLine line{ray.origin, ray.direction, ray.t_near, t_far, blocked};
  for (size_t i = 0; i < seen_.size(); ++i) {
    const LuminaireRole& role = seen_[i].role();
    if (!(mirrors == 0 ? role.to_camera : role.in_mirrors)) continue;
    const double seen = seen_[i].seen_along(line);
    if (seen <= 0) continue;
    const Vec3d radiance = throughput * seen_[i].radiance() * seen;
    if (record) record->shine(radiance, mirrors, seen_[i].light_group());
    end.background += radiance;
    end.first.lights |= uint64_t{1} << i % 64;
  }
}

bool PathTracer::is_plain(const Hit& hit) const {
  if (!hit.found()) return !scene_.background().seen_by_camera || !scene_.background().environment;
  const uint32_t material = geometry_.material_of(hit);
  return ends_paths_[material] && !geometry_.traits_of(hit.instance).holdout &&
         !scene_.materials()[material].may_be_glossy() && !geometry_.is_strand(hit);
}

uint64_t PathTracer::lights_seen(const Ray& ray, const Hit& hit) const {
  const SightLine line{ray.origin, ray.direction, ray.t_near, hit.found() ? hit.t : ray.t_far, hit.found()};
  uint64_t lights = 0;
  for (size_t i = 0; i < seen_.size(); ++i)
    if (seen_[i].role().to_camera && seen_[i].seen_along(line) > 0) lights |= uint64_t{1} << i % 64;
  return lights;
}

/// The data passes show that surface; t: of the primary ray before.
void PathTracer::see(const SurfacePoint& surface, const Hit& hit, double t, PathEnd& end) const {
  end.first.hit = true;
  end.first.object = &geometry_.name_of(hit);
  end.first.position = surface.position;
  end.first.geometric_normal = Vec3f(surface.geometric_normal);
  end.first.normal = Vec3f(surface.normal);
  end.first.t = t + surface.t;
}

void PathTracer::follow(const HitColumns& found, uint32_t ray, uint32_t pixel, uint64_t stream,
                        std::vector<LitPoint>& points, uint64_t& mirror_rays, PathEnd& end,
                        const PathRecord* record) const {
  // Field by field: `first` has no place without a hit.
  end.background = {};
  end.alpha = 1;
  end.first.lights = 0;
  end.first.hit = false;
  end.first.object = nullptr;
  // Most rays: an opaque surface that only reflects ends the path.
  if (const Hit& hit = found.hits[ray]; !record && hit.found()) {
    const uint32_t material = geometry_.material_of(hit);
    if (ends_paths_[material] && !geometry_.traits_of(hit.instance).holdout) {
      LitPoint& point = points.emplace_back();
      geometry_.surface_point(found, ray, point.surface);
      see(point.surface, hit, 0, end);
      see_luminaires(found.rays[ray], point.surface.t, true, {1, 1, 1}, 0, end, nullptr);
      point.ray_direction = found.rays[ray].direction;
      point.material = &scene_.materials()[material];
      point.throughput = {1, 1, 1};
      point.stream = stream * length();
      point.pixel = pixel;
      point.bounce = 0;
      point.mirrored = false;
      return;
    }
  }
  uint32_t lit = 0, rays = 0;
  std::vector<Part> waiting;  // mirrors in surfaces that the path went through
  Part part(found.rays[ray], found.hits[ray], perspective_ ? 0 : pixel_ * scale_);
  for (;;) {
    const double negligible = rays == 0          ? kNegligible
                              : rays < kMostRays ? std::ldexp(kNegligible, int(rays / kRaysPerDoubling))
                                                 : INFINITY;
    bool goes_on = false;
    if (!part.hit.found()) {
      see_luminaires(part.ray, part.ray.t_far, false, part.throughput, part.mirrors, end, record);
      leave(part, end, record);
    } else {
      PlacedPoint surface;
      if (rays == 0)
        geometry_.surface_point(found, ray, surface);
      else
        geometry_.surface_point(part.ray, part.hit, surface);
      const ObjectTraits& traits = geometry_.traits_of(part.hit.instance);
      const Material& material = scene_.materials()[surface.material];
      const double t = surface.t;
      see_luminaires(part.ray, t, true, part.throughput, part.mirrors, end, record);
      const double footprint =
          part.footprint + (perspective_ ? t * pixel_ * (part.from_camera() ? scale_ : 1.0) : 0.0);
      std::shared_ptr<const Closures> evaluated;
      if (material.program)
        evaluated = std::make_shared<const Closures>(materials_.evaluate(
            *material.program, surface,
            {part.ray.direction, part.from_camera() ? RayKind::kCamera : RayKind::kMirror, footprint}));
      const bool is_hole = traits.holdout && part.from_camera();
      if (is_hole) evaluated = hole_of(evaluated ? *evaluated : material);
      const Closures& closures = evaluated ? *evaluated : material;
      const double through = closures.transparency == Vec3d{} ? 0 : average(closures.transparency);
      if (is_hole && !end.first.object) end.first.object = &geometry_.name_of(part.hit);
      if (!is_hole && !end.first.hit && part.from_camera() && 1 - through > kSeenOpacity) {
        see(surface, part.hit, part.t, end);
        if (record && record->seen) *record->seen = {part.hit.instance, surface.material, surface.place};
      }
      if (record)
        record->meet({surface, closures, part.throughput, part.mirrors, part.hit.instance, traits.light_group,
                      std::abs(dot(normalize(part.ray.direction), surface.normal)),
                      (part.t + t) * penumbra::length(part.ray.direction) / scale_});
      end.background += part.throughput * closures.emission;
      if (part.from_camera()) end.alpha -= average(part.throughput) * closures.holdout;
      const Vec3d position = surface.position, outward = surface.geometric_normal * surface.rounding,
                  normal = surface.normal;
      if (lit < length_ && !is_hole && (closures.reflects() || through == 0)) {
        LitPoint& point = points.emplace_back();
        point.surface = surface;
        point.ray_direction = part.ray.direction;
        point.material = &closures;
        point.throughput = part.throughput;
        point.stream = stream * length() + lit;
        point.pixel = pixel;
        point.bounce = lit;
        point.mirrored = !part.from_camera();
        point.evaluated = evaluated;
        ++lit;
      }

      const Vec3d reflected = part.throughput * closures.mirror,
                  passing = part.throughput * closures.transparency;
      if (part.mirrors < mirror_depth_ && max_component(reflected) > negligible) {
        Part mirrored = part;
        mirrored.ray = {position + outward, normalize(reflect(part.ray.direction, normal)), 0, 1e30,
                        kMirrorRay};
        mirrored.throughput = reflected;
        mirrored.footprint = footprint;
        mirrored.t = 0;
        ++mirrored.mirrors;
        waiting.push_back(mirrored);
      }
      if (max_component(passing) > negligible && part.passed < kMaxPassed) {
        part.ray.origin = position - outward;
        part.ray.t_near = 0;
        part.ray.t_far -= t;
        part.throughput = passing;
        part.footprint = footprint;
        part.t += t;
        ++part.passed;
        goes_on = true;
      }
    }
    if (!goes_on) {
      if (waiting.empty()) return;
      part = waiting.back();
      waiting.pop_back();
    }
    geometry_.intersect(&part.ray, 1, &part.hit);
    ++mirror_rays;
    ++rays;
  }
}

}  // namespace penumbra
