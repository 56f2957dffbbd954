// SPDX-License-Identifier: GPL-3.0-or-later
// The sky as a light: of one radiance everywhere, or as a picture has it.
#pragma once

#include <memory>
#include <vector>

#include "luminaire/emitter.h"
#include "scene/environment.h"

namespace penumbra {

/// The same radiance from everywhere.
class ConstantSky final : public Emitter {
 public:
  bool is_wide() const override { return true; }
  double form_factor(const SurfacePoint&) const override { return 1; }
  /// With density cos / pi around the surface's normal.
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const override;
};

/// One channel of a picture of the sky, to be drawn from and summed up; in the picture's own directions.
class SkyTable {
 public:
  /// weights: the channel, width x height, none negative; rows from straight down up.
  SkyTable(const std::vector<float>& weights, uint32_t width, uint32_t height);

  /// Over the sphere, in units of the weights.
  double mean() const { return mean_; }
  /// Unit direction with density in proportion to radiance: uniformly in solid angle within a pixel.
  Vec3f direction(float u, float v) const;
  /// The form factor of a sky with the picture's mean has 1.
  double form_factor(const Vec3f& normal) const;

 private:
  void sum_cells(const std::vector<float>& weights);

  uint32_t width_, height_;
  double mean_ = 0;
  std::vector<float> heights_;    // z at the lower edge of each row
  std::vector<float> rows_;       // cumulative power of rows, height + 1, ends with 1
  std::vector<float> columns_;    // of the pixels in each row, height x (width + 1)
  std::vector<float> x_, y_, z_;  // of the cells: their directions times their light
};

/// One channel of a picture of the sky, each pixel of constant radiance; a form factor of 1 is that of a sky
/// with the picture's mean.
class PictureSky final : public Emitter {
 public:
  PictureSky(std::shared_ptr<const SkyTable> table, const Affine& local_from_world);

  bool dark() const override { return !(table_->mean() > 0); }
  bool is_wide() const override { return true; }
  /// Exact but for the horizon's way through cells of 2.8 degrees.
  double form_factor(const SurfacePoint& surface) const override;
  /// With density in proportion to radiance.
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const override;

 private:
  std::shared_ptr<const SkyTable> table_;
  Vec3f axes_[3];  // world from local
};

}  // namespace penumbra
