// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/textured_luminaires.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "luminaire/cone.h"
#include "luminaire/mesh_emitter.h"

namespace penumbra {
namespace {

/// Emission is looked up so often on a luminaire, shared out by area: a picture of 256 x 256 is met at each
/// pixel. At most 4^kDeepest times on a triangle.
constexpr double kLookups = 65536;
constexpr int kDeepest = 8;
/// Directions that emission which depends on them is looked up in: its mean is within 0.7 % for Schlick's
/// fifth power, the steepest of the usual ones.
constexpr int kDirections = 16;
constexpr double kGoldenAngle = 2.399963229728653;  // radians
/// Parts beyond the triangles that there are: each costs every surface point some nanoseconds. What that
/// leaves of the light's variation is measured by tests/blender/test_textured_emission.py.
constexpr size_t kMostParts = 256;
/// No part is split for less than this share of the whole power.
constexpr double kEnough = 1e-5;

struct Barycentrics {
  double u, v;

  friend Barycentrics between(const Barycentrics& a, const Barycentrics& b) {
    return {(a.u + b.u) / 2, (a.v + b.v) / 2};
  }
};
using Part = std::array<Barycentrics, 3>;

/// The four halves of a triangle's edges; the third is turned around.
Part child_of(const Part& p, int k) {
  const Barycentrics ab = between(p[0], p[1]), bc = between(p[1], p[2]), ca = between(p[2], p[0]);
  switch (k) {
    case 0:
      return {p[0], ab, ca};
    case 1:
      return {ab, p[1], bc};
    case 2:
      return {bc, ca, ab};
    default:
      return {ca, bc, p[2]};
  }
}

/// Means of the emission of one triangle's parts: levels[l] has 4^l of them, those of part i at 4 i + k.
struct Pyramid {
  Hit hit;
  double area;
  std::vector<std::vector<Vec3d>> levels;
};

/// A part that may be split.
struct Candidate {
  double gain;  // power that is in the wrong place without
  uint32_t pyramid;
  int level;
  uint32_t index;
  Part part;

  bool operator<(const Candidate& o) const {
    return gain != o.gain ? gain < o.gain : std::pair(pyramid, index) > std::pair(o.pyramid, o.index);
  }
};

/// What one side of an instance sends.
class Side {
 public:
  Side(const Scene& scene, const Geometry& geometry, const Materials& materials, uint32_t instance,
       bool from_behind);

  bool dark() const { return power_ <= 0; }
  /// As triangles in render space with the emission of each; their normals are on this side.
  void split(MeshLuminaire& parts, std::vector<Vec3d>& emission) const;
  bool sends_what(const Side& other) const;

 private:
  void look_up(Pyramid& pyramid, const Material& material, double share);
  Vec3d emission(const Material& material, const PlacedPoint& surface, double width) const;
  double gain(const Pyramid& pyramid, int level, uint32_t index) const;

  const Geometry& geometry_;
  const Materials& materials_;
  bool from_behind_;
  std::vector<Pyramid> pyramids_;
  double power_ = 0;
};

Side::Side(const Scene& scene, const Geometry& geometry, const Materials& materials, uint32_t instance,
           bool from_behind)
    : geometry_(geometry), materials_(materials), from_behind_(from_behind) {
  double area = 0;
  for (uint32_t t = 0; t < geometry.triangles_of(instance); ++t) {
    const Hit hit{instance, t};
    const PlacedPoint a = geometry.surface_point(hit, 0, 0, from_behind);
    if (!scene.materials()[a.material].emission_program) continue;
    const Vec3d b = geometry.surface_point(hit, 1, 0, from_behind).position,
                c = geometry.surface_point(hit, 0, 1, from_behind).position;
    pyramids_.push_back({hit, length(cross(b - a.position, c - a.position)) / 2, {}});
    area += pyramids_.back().area;
  }
  for (Pyramid& pyramid : pyramids_) {
    const uint32_t material = geometry.surface_point(pyramid.hit, 0, 0, from_behind).material;
    look_up(pyramid, scene.materials()[material], area > 0 ? pyramid.area / area : 0);
    power_ += pyramid.area * max_component(pyramid.levels[0][0]);
  }
}

/// share: of the luminaire's area.
void Side::look_up(Pyramid& pyramid, const Material& material, double share) {
  const int depth = std::clamp(int(std::log2(std::max(share * kLookups, 1.0)) / 2), 0, kDeepest);
  const double width = std::sqrt(pyramid.area) / std::exp2(depth);
  std::vector<Part> parts{{Barycentrics{0, 0}, {1, 0}, {0, 1}}};
  for (int level = 0; level < depth; ++level) {
    std::vector<Part> finer;
    for (const Part& part : parts)
      for (int k = 0; k < 4; ++k) finer.push_back(child_of(part, k));
    parts = std::move(finer);
  }
  pyramid.levels.resize(size_t(depth) + 1);
  for (const Part& p : parts) {
    const PlacedPoint surface = geometry_.surface_point(pyramid.hit, (p[0].u + p[1].u + p[2].u) / 3,
                                                        (p[0].v + p[1].v + p[2].v) / 3, from_behind_);
    pyramid.levels.back().push_back(emission(material, surface, width));
  }
  for (int level = depth; level-- > 0;) {
    const std::vector<Vec3d>& finer = pyramid.levels[size_t(level) + 1];
    for (size_t i = 0; i < finer.size(); i += 4)
      pyramid.levels[size_t(level)].push_back((finer[i] + finer[i + 1] + finer[i + 2] + finer[i + 3]) / 4.0);
  }
}

/// Mean over the directions to the surface's side, weighted with the cosine as its power is. (One direction
/// is enough where emission does not depend on it.)
Vec3d Side::emission(const Material& material, const PlacedPoint& surface, double width) const {
  const Vec3d& n = surface.geometric_normal;
  const Across across(n);
  const auto towards = [&](double cosine, double angle) {
    PlacedPoint copy = surface;  // bumps change its normal
    const Vec3d sideways = across.side * std::cos(angle) + across.up * std::sin(angle),
                viewer = n * cosine + sideways * std::sqrt(1 - cosine * cosine);
    const Vec3d e =
        materials_.evaluate(*material.emission_program, copy, {-viewer, RayKind::kLight, width}).emission;
    return is_finite(e) ? Vec3d{std::max(e.x, 0.0), std::max(e.y, 0.0), std::max(e.z, 0.0)} : Vec3d{};
  };
  if (!material.emission_program->looks_at_viewer) return towards(1, 0);
  Vec3d sum;
  for (int i = 0; i < kDirections; ++i) {
    const double cosine = (i + 0.5) / kDirections;
    sum += towards(cosine, kGoldenAngle * i) * (2 * cosine / kDirections);
  }
  return sum;
}

/// From the finest level, so that a picture whose quarters are alike is split nevertheless.
double Side::gain(const Pyramid& pyramid, int level, uint32_t index) const {
  const int depth = int(pyramid.levels.size()) - 1;
  if (level == depth) return 0;
  const Vec3d& mean = pyramid.levels[size_t(level)][index];
  const int below = std::min(depth - level, 3);  // 64 parts tell enough
  const uint32_t count = 1u << 2 * below;
  const std::vector<Vec3d>& finer = pyramid.levels[size_t(level + below)];
  double sum = 0;
  for (uint32_t i = 0; i < count; ++i) sum += max_abs(finer[index * count + i] - mean);
  return sum / count * pyramid.area / std::exp2(2 * level);
}

void Side::split(MeshLuminaire& parts, std::vector<Vec3d>& emission) const {
  std::priority_queue<Candidate> open;
  for (uint32_t i = 0; i < pyramids_.size(); ++i)
    open.push({gain(pyramids_[i], 0, 0), i, 0, 0, {Barycentrics{0, 0}, {1, 0}, {0, 1}}});
  size_t count = open.size();
  std::vector<Candidate> done;
  while (!open.empty()) {
    const Candidate c = open.top();
    open.pop();
    if (c.gain <= kEnough * power_ || count + 3 > pyramids_.size() + kMostParts) {
      done.push_back(c);
      continue;
    }
    count += 3;
    for (uint32_t k = 0; k < 4; ++k)
      open.push({gain(pyramids_[c.pyramid], c.level + 1, 4 * c.index + k), c.pyramid, c.level + 1,
                 4 * c.index + k, child_of(c.part, int(k))});
  }
  for (const Candidate& c : done) {
    const Pyramid& pyramid = pyramids_[c.pyramid];
    const Vec3d& mean = pyramid.levels[size_t(c.level)][c.index];
    if (max_component(mean) <= 0) continue;
    Vec3d at[3], normal;
    for (int i = 0; i < 3; ++i) {
      const PlacedPoint s = geometry_.surface_point(pyramid.hit, c.part[i].u, c.part[i].v, from_behind_);
      at[i] = s.position;
      normal = s.geometric_normal;
    }
    if (dot(cross(at[1] - at[0], at[2] - at[0]), normal) < 0) std::swap(at[1], at[2]);
    const auto first = uint32_t(parts.positions.size());
    parts.positions.insert(parts.positions.end(), at, at + 3);
    parts.triangles.push_back({first, first + 1, first + 2});
    emission.push_back(mean);
  }
}

bool Side::sends_what(const Side& other) const {
  for (size_t i = 0; i < pyramids_.size(); ++i)
    if (pyramids_[i].levels.back() != other.pyramids_[i].levels.back()) return false;
  return true;
}

/// The one hue of all parts, its largest component 1, or nothing.
std::optional<Vec3d> hue_of(const std::vector<Vec3d>& emission) {
  Vec3d sum;
  for (const Vec3d& e : emission) sum += e;
  const Vec3d hue = sum / max_component(sum);
  for (const Vec3d& e : emission)
    if (max_abs(e - hue * max_component(e)) > 1e-5 * max_component(e)) return std::nullopt;
  return hue;
}

void add_side(const TexturedLuminaire& description, const Side& side, bool one_sided,
              std::vector<Luminaire>& out) {
  MeshLuminaire parts;
  parts.name = description.name;
  parts.role = description.role;
  parts.one_sided = one_sided;
  std::vector<Vec3d> emission;
  side.split(parts, emission);
  if (emission.empty()) return;
  const auto add = [&](const Vec3d& radiance, auto weight_of) {
    parts.radiance = radiance;
    parts.weights.clear();
    for (const Vec3d& e : emission) parts.weights.push_back(float(weight_of(e)));
    out.emplace_back(parts, Normalization{}, description.light_group);  // in render space already
  };
  if (const auto hue = hue_of(emission)) {
    add(*hue, [](const Vec3d& e) { return max_component(e); });
    return;
  }
  add({1, 0, 0}, [](const Vec3d& e) { return e.x; });
  add({0, 1, 0}, [](const Vec3d& e) { return e.y; });
  add({0, 0, 1}, [](const Vec3d& e) { return e.z; });
}

}  // namespace

std::vector<Luminaire> textured_luminaires(const Scene& scene, const Geometry& geometry,
                                           const Materials& materials) {
  std::vector<Luminaire> result;
  for (const TexturedLuminaire& description : scene.textured_luminaires()) {
    const Side front(scene, geometry, materials, description.instance, false),
        back(scene, geometry, materials, description.instance, true);
    const bool alike = front.sends_what(back);
    if (!front.dark()) add_side(description, front, !alike, result);
    if (!alike && !back.dark()) add_side(description, back, true, result);
  }
  return result;
}

}  // namespace penumbra
