// SPDX-License-Identifier: GPL-3.0-or-later
// Luminaires of every kind for the tests of the light tree.
#pragma once

#include <limits>
#include <vector>

#include "luminaire/luminaire.h"
#include "oracles.h"

namespace penumbra::test {

/// Groups that share nothing between surface points.
inline constexpr double kUnshared = std::numeric_limits<double>::infinity();

inline Affine turned(Trials& trials, const Vec3d& at, double scale) {
  const Vec3d z = trials.direction();
  const Vec3d x = normalize(cross(z, std::abs(z.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
  return {x * scale, cross(z, x) * scale, z * scale, at};
}

inline MeshLuminaire tetrahedron(const Affine& t, const Vec3d& radiance, bool closed) {
  MeshLuminaire mesh{"tetrahedron", {}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}}, radiance};
  if (closed) mesh.triangles.push_back({0, 3, 2});
  for (const Vec3d& p : {Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
    mesh.positions.push_back(t.point(p));
  return mesh;
}

/// One of six kinds, or of five without beams.
inline LuminaireDescription described(uint32_t i, Trials& trials, bool colours, bool beams) {
  const Vec3d at{trials.uniform(-1, 1), trials.uniform(-1, 1), trials.uniform(-1, 1)};
  const double size = trials.uniform(0.005, 0.05), bright = trials.uniform(1, 5);
  const Vec3d radiance = colours && i % 2 ? Vec3d{bright, bright / 2, 0} : Vec3d{bright, bright, bright};
  const Affine t = turned(trials, at, size);
  switch (beams ? i % 6 : i % 5) {
    case 0:
      return AreaLuminaire{"rectangle", LuminaireShape::kRectangle, t, 1, trials.uniform(0.2, 1), radiance};
    case 1:
      return AreaLuminaire{"ellipse", LuminaireShape::kEllipse, t, 1, trials.uniform(0.2, 1), radiance};
    case 2:
      return PointLuminaire{
          "bulb", RoundShape::kSphere, t, i % 4 ? 0.0 : size, radiance * (size * size), true, {}};
    case 3: {
      PointLuminaire spot{"spot", RoundShape::kFacingDisk, t, size, radiance * (size * size), true, {}};
      if (beams && i % 4 == 1) spot.spot = SpotCone{1.0, 0.5};
      return spot;
    }
    case 4:
      return tetrahedron(t, radiance, i % 4 == 0);
    default:
      return AreaLuminaire{"soft box", LuminaireShape::kRectangle, t, 1, 1, radiance, true, 1.5};
  }
}

/// Of every kind, in the cube [-1, 1]^3.
inline std::vector<Luminaire> many(uint32_t count, Trials& trials, bool colours = true, bool beams = true) {
  std::vector<Luminaire> luminaires;
  for (uint32_t i = 0; i < count; ++i)
    luminaires.emplace_back(described(i, trials, colours, beams), Normalization{});
  return luminaires;
}

inline Vec3d exact_sum(const std::vector<Luminaire>& luminaires, const SurfacePoint& surface) {
  Vec3d sum;
  for (const Luminaire& l : luminaires) sum += l.radiance() * l.form_factor(surface);
  return sum;
}

/// Mean form factor of points that choose from a luminaire's elements evenly.
inline double mean_of_points(const Luminaire& luminaire, const SurfacePoint& surface, Trials& trials) {
  LightPoints points;
  alignas(64) float u[kBatch], v[kBatch];
  constexpr uint32_t kPoints = 1 << 16;
  double sum = 0;
  for (uint32_t first = 0; first < kPoints; first += kBatch) {
    for (uint32_t k = 0; k < kBatch; ++k) {
      u[k] = (float(first + k) + 0.5f) / kPoints;
      v[k] = float(trials.uniform(0, 1));
    }
    luminaire.evaluate(surface, u, v, kBatch, points);
    for (float f : points.form_factor) sum += double(f);
  }
  return sum / kPoints;
}

}  // namespace penumbra::test
