// SPDX-License-Identifier: GPL-3.0-or-later
// Many luminaires in a tree, so that those which matter little to a part of the picture count as one.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "luminaire/light_columns.h"
#include "luminaire/luminaire.h"
#include "math/transform.h"

namespace penumbra {

/// What of a luminaire's colour a group is about: its largest component, where all have the same hue, or one
/// channel.
enum class LightChannel { kLargest, kRed, kGreen, kBlue };

/// Elements next to each other, and what they can send at most.
struct LightNode {
  Box bounds;              // holds every point of them
  Vec3d axis;              // the normals lie in a cone around it,
  double cosine = -1;      // of this half angle; -1: any direction
  Vec3d power;             // sum of strength x |radiance|
  uint32_t begin, end;     // elements, in the tree's order
  uint32_t right = 0;      // child; the left one is the next node. 0: a leaf
  double near = 0;         // beyond, cos cos' / r^2 holds for all of them, by four points each
  bool one_colour = true;  // radiances are multiples of each other

  bool is_leaf() const { return right == 0; }
  /// All of it is above, or below, a surface point's horizon.
  bool is_above(const SurfacePoint& surface) const { return height(surface, -1) >= 0; }
  bool is_below(const SurfacePoint& surface) const { return height(surface, 1) <= 0; }

  /// Upper bound of the sum of |radiance| x form factor at a surface point, infinite within the bounds.
  Vec3d bound(const SurfacePoint& surface) const;

 private:
  /// Of the bounds' highest (side 1) or lowest (-1) point above the horizon.
  double height(const SurfacePoint& surface, int side) const;
};

class LightTree {
 public:
  explicit LightTree(std::vector<Luminaire> luminaires);

  const LightNode& node(uint32_t i) const { return nodes_[i]; }
  /// One for luminaires with and without shadows, and for those that take light away.
  const std::vector<uint32_t>& roots() const { return roots_; }
  /// Those that cannot be grouped: the sun, the sky.
  const std::vector<Luminaire>& rest() const { return rest_; }

  /// Luminaires that shine as the node's elements do: the only one as it is, else a group, or three of
  /// different colours. They refer to the tree. smallest_side: as for LightGroup.
  void append(uint32_t node, double smallest_side, std::vector<Luminaire>& out) const;
  /// How many append() makes.
  uint32_t count(uint32_t node) const;

  /// Sum over elements [begin, end) of |radiance| x form factor, one channel; each by its closed form, or
  /// where it is far by four points or one (relative error 5e-4, tests/native/test_light_tree.cpp).
  /// values: of each element, unless null.
  double sum(uint32_t begin, uint32_t end, LightChannel channel, const SurfacePoint& surface,
             float* values) const;

  /// The same for many surface points and at most kLightChunk elements; value e * kBatch + i: of element
  /// begin + e at point i.
  void sums(uint32_t begin, uint32_t end, LightChannel channel, const SurfaceColumns& surfaces, float* values,
            double* out) const;

  /// The node is so far from a surface point, and so far above its horizon, that its elements' powers tell
  /// well enough what they send.
  bool is_far(uint32_t node, const SurfacePoint& surface) const;
  /// The sum of its elements' |radiance| x form factor at a surface with normal n is n . this, where all of
  /// them are above the horizon. Elements nearer to `middle` than some radii are four points each.
  Vec3d vector_light(uint32_t node, LightChannel channel, const Vec3d& point, const Vec3d& middle) const;
  /// Share of its power from flat elements whose plane is within `distance` of a point.
  double turning_power(uint32_t node, LightChannel channel, const Vec3d& point, double distance) const;
  /// An element of the node by its power: `at` in [0, 1) goes through them in order. share: the probability;
  /// within: where in the element's own part `at` is, in [0, 1).
  uint32_t pick(uint32_t node, LightChannel channel, double at, double& share, double& within) const;

  /// Points of one element: (u, v) in its part of the emitter's square. Form factors are those of the element
  /// times |radiance|.
  void evaluate(uint32_t element, LightChannel channel, const SurfacePoint& surface, const float* u,
                const float* v, uint32_t count, LightPoints& out) const;
  /// One for each of many surface points.
  void evaluate_each(uint32_t element, LightChannel channel, const SurfaceColumns& surfaces, const float* u,
                     const float* v, LightPoints& out) const;

 private:
  struct Source {
    const Emitter* emitter;
    uint32_t luminaire, element;  // which of the luminaire's
    float u_begin, u_end;
    float radiance[4];  // |radiance|, by channel

    void to_emitter(const float* u, uint32_t count, float* out) const;
    void weigh(LightChannel channel, uint32_t count, float* form_factors) const;
  };
  struct Building;
  void add_root(std::vector<Building>& elements);
  uint32_t add_node(std::span<Building> elements, uint32_t begin);
  void fill_columns(std::span<const Building> elements);

  std::vector<Luminaire> luminaires_, rest_;
  std::vector<LightNode> nodes_;
  std::vector<uint32_t> roots_;
  std::vector<Source> sources_;                     // by element, in the tree's order
  std::vector<std::vector<float>> columns_;         // see light_columns.cpp
  std::array<std::vector<double>, 4> power_until_;  // by channel: sums of strength x |radiance| up to each
  size_t largest_leaf_ = 1;
};

}  // namespace penumbra
