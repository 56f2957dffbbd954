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
  /// u goes through the tree's order, where near numbers are near in space. From far elements are chosen by
  /// their power, else by what they would send to the surface point, so that all points count nearly the same
  /// however much nearer one of them is.
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const override;

 private:
  /// Puts point i of `out` where `choice` has (u, v).
  template <typename Choice>
  void place(const Choice& choice, const SurfacePoint& surface, float u, float v, LightPoints& out,
             uint32_t i) const;

  const LightTree& tree_;
  uint32_t node_;
  LightChannel channel_;
  mutable LightCells cells_;  // those of a block belong to one thread
};

}  // namespace penumbra
