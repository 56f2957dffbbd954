// SPDX-License-Identifier: GPL-3.0-or-later
// The passes that a render has only where they are asked for: light taken apart, colours, indices, mattes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "render/film.h"
#include "render/paths.h"

namespace penumbra {

/// What a pixel's samples told of it.
struct PixelParts {
  std::span<const Vec3d> parts;  // means over the samples, see Part
  std::span<const MatteHit> mattes;
  double samples;  // that the mattes' weights were added over
};

class ExtraPasses {
 public:
  /// Throws std::invalid_argument for a light group that the scene has not got.
  ExtraPasses(const std::vector<std::string>& names, const Scene& scene, const Geometry& geometry,
              Film& film);

  bool any() const { return !passes_.empty(); }
  bool want_parts() const { return want_parts_; }
  bool want_mattes() const { return want_mattes_; }
  uint32_t light_groups() const { return uint32_t(scene_.light_groups().size()); }

  /// x, y: full-frame pixel inside the film's region; seen: by its first sample. A value that is not
  /// finite is written as zero; returns whether there was one.
  bool write(uint32_t x, uint32_t y, const SeenObject& seen, const PixelParts& pixel) const;

 private:
  enum class Kind { kPart, kLight, kShadow, kMist, kUv, kObjectIndex, kMaterialIndex, kMatte };
  enum class Matte { kObject, kMaterial, kAsset };
  struct Pass {
    Kind kind;
    uint32_t part = 0, colour = 0;  // kLight: the part divided by its colour
    Matte matte = Matte::kObject;
    uint32_t level = 0;  // of the matte: ranks 2 level and 2 level + 1
    float* pixels = nullptr;
    uint32_t channels = 0;
  };
  struct Rank {
    float id;
    double coverage;
  };
  Pass pass_of(const std::string& name) const;
  void value(const Pass& pass, const SeenObject& seen, const PixelParts& pixel, double* out) const;
  std::vector<Rank> ranks(Matte matte, const PixelParts& pixel) const;

  const Scene& scene_;
  const Geometry& geometry_;
  Rectangle region_;
  std::vector<Pass> passes_;
  bool want_parts_ = false, want_mattes_ = false;
};

}  // namespace penumbra
