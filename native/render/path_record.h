// SPDX-License-Identifier: GPL-3.0-or-later
// What a path tells passes beside the surface points that it found.
#pragma once

#include <span>
#include <vector>

#include "lighting/light_parts.h"
#include "render/settings.h"

namespace penumbra {

/// How much of what the camera sees is one object's part of one material.
struct MatteHit {
  uint32_t instance, material;
  double weight;
};

/// Adds a hit to a list that has each pair of object and material once.
void add_matte(std::vector<MatteHit>& hits, const MatteHit& hit);

/// The surface that the data passes show.
struct SeenObject {
  uint32_t instance = Hit::kNone, material = 0;
  SurfacePlace place = {};
};

/// A surface that a path has met.
struct SurfaceMet {
  const SurfacePoint& surface;
  const Closures& closures;
  const Vec3d& throughput;  // before it
  uint32_t mirrors;         // before it
  uint32_t instance, light_group;
  double cosine;    // of the angle between ray and shading normal
  double distance;  // from the camera, world units; without mirrors
};

/// Where one path writes; a part that nobody wants is empty.
struct PathRecord {
  std::span<Vec3d> parts = {};  // of its pixel, see Part
  std::vector<MatteHit>* mattes = nullptr;
  const MistSettings* mist = nullptr;
  SeenObject* seen = nullptr;

  void meet(const SurfaceMet& met) const;
  /// Light of what is seen itself, by way of so many mirrors.
  void shine(const Vec3d& radiance, uint32_t mirrors, uint32_t light_group) const;
  /// The world behind everything. shown: in Combined, which that behind a transparent film is not.
  void leave(const Vec3d& radiance, uint32_t mirrors, uint32_t light_group, bool shown) const;

 private:
  void add(const Vec3d& radiance, Part seen, uint32_t mirrors, uint32_t light_group) const;
};

}  // namespace penumbra
