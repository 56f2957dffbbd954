// SPDX-License-Identifier: GPL-3.0-or-later
// Neighbouring luminaires as one.
#pragma once

#include "luminaire/light_cells.h"

namespace penumbra {

/// Form factors are per channel of radiance 1: elements of different strength count by their radiance.
class LightGroup final : public Emitter {
 public:
  /// The elements of a tree's node; the tree must live as long. smallest_side: see LightCells; infinite:
  /// none, which several threads may use at once.
  LightGroup(const LightTree& tree, uint32_t node, LightChannel channel, double smallest_side);

  double form_factor(const SurfacePoint& surface) const override;
  void form_factors(const SurfaceColumns& surfaces, double* out) const override;
  /// u goes through the tree's order, where near numbers are near in space. From far elements are chosen by
  /// their power, else by what they would send to the surface point, so that all points count nearly the same
  /// however much nearer one of them is.
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const override;

  void evaluate_each(const SurfaceColumns& surfaces, const float* u, const float* v, uint32_t points,
                     LightPoints& out) const override;

 private:
  /// Calls function with what a surface point chooses elements by, unless it sees none. values: what they
  /// send it, kBatch apart, if that is known.
  template <typename Function>
  void choose(const SurfacePoint& surface, const float* values, Function function) const;
  /// Calls function with those of one element, for each element.
  template <typename Picked, typename Function>
  void for_elements(std::span<const Picked> picked, Function function) const;

  const LightTree& tree_;
  uint32_t node_;
  LightChannel channel_;
  mutable LightCells cells_;  // those of a block belong to one thread
};

}  // namespace penumbra
