// SPDX-License-Identifier: GPL-3.0-or-later
// The light of far elements in cubes of space: surface points in one cube share what it took to find it.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "luminaire/light_tree.h"

namespace penumbra {

/// Elements of a node by the light that they send to one surface point.
class LightChoice {
 public:
  void fill(const LightTree& tree, uint32_t node, LightChannel channel, const SurfacePoint& surface);
  /// The same from what the elements send, `stride` apart.
  void fill(uint32_t begin, uint32_t count, const float* values, uint32_t stride);
  /// As LightTree::pick(); nothing where share is 0.
  uint32_t pick(double at, double& share, double& within) const;

 private:
  void add_up();

  static constexpr uint32_t kGuides = 64;
  uint32_t begin_ = 0;
  std::vector<float> values_;
  std::vector<double> until_;            // sum of values up to each element, itself included
  std::array<uint32_t, kGuides> guide_;  // which element's sum is the first beyond each 64th of the total
};

/// For one group of luminaires. What a surface point gets depends on that point alone, not on what was asked
/// before. Not for several threads at once.
class LightCells {
 public:
  /// Fewer elements are asked one by one.
  static constexpr uint32_t kWorthACube = 48;

  /// smallest_side: smaller cubes hold too few surface points to be worth it.
  LightCells(const LightTree& tree, uint32_t node, LightChannel channel, double smallest_side)
      : tree_(tree), root_(node), channel_(channel), smallest_side_(smallest_side) {}

  /// Sum of |radiance| x form factor, of cubes where that is good for 1e-3 of a facing light at worst, 1e-4
  /// in the mean (tests/native/test_light_cells.cpp), else element by element.
  double form_factor(const SurfacePoint& surface) { return form_factor(root_, surface); }
  void form_factors(const SurfaceColumns& surfaces, double* out);
  /// Its elements are asked one by one.
  bool is_small() const;
  /// What the surface points of a cube that face one way choose by; null where they do not share one.
  const LightChoice* choice(const SurfacePoint& surface);

 private:
  struct Key {
    uint32_t node;
    int level;
    int64_t x, y, z;
    int normal;  // quantised, of a choice
    bool operator==(const Key&) const = default;
  };
  struct KeyHash {
    size_t operator()(const Key& key) const;
  };
  /// Vector irradiance / pi at 3 x 3 x 3 Chebyshev points of a cube, which a parabola in each direction
  /// joins.
  struct Field {
    alignas(64) float values[3][32];
    bool smooth;
    /// t: place in the cube, from -1 to 1.
    Vec3d at(const Vec3d& t) const;
  };

  double form_factor(uint32_t node, const SurfacePoint& surface);
  /// The node's cube around a point; false: it would be too small.
  bool cube(uint32_t node, const Vec3d& point, Key& key, Vec3d& centre, double& side) const;
  const Field& field(const Key& key, const Vec3d& centre, double side);

  const LightTree& tree_;
  uint32_t root_;
  LightChannel channel_;
  double smallest_side_;
  std::unordered_map<Key, std::unique_ptr<Field>, KeyHash> fields_;
  std::unordered_map<Key, std::unique_ptr<LightChoice>, KeyHash> choices_;
};

/// The smallest cubes, of sides that are powers of two, in which enough of some evenly spread surface points
/// come to lie together; infinite if none do.
double shared_cube_side(std::span<const Vec3d> points);

}  // namespace penumbra
