// SPDX-License-Identifier: GPL-3.0-or-later
// What a material's operations work on: registers, the surface at one point and beside it, textures.
#pragma once

#include <span>
#include <utility>

#include "scene/attributes.h"
#include "scene/program.h"

namespace penumbra {

class Textures;

/// kLight: none that is seen; light that a surface sends to others.
enum class RayKind : uint8_t { kCamera, kMirror, kShadow, kLight };

/// The surface at a point as node trees see it: world space, metres.
struct SurfaceSample {
  Vec3f position, object_position;
  float u = 0, v = 0;  // barycentric
};

/// One evaluation of a program.
struct Machine {
  Vec3f* registers;
  const float* tables;
  const SurfacePlace* place;
  SurfaceSample at[3];             // here, and a footprint to either side
  Vec3f normal, geometric_normal;  // unit, on the viewer's side
  Vec3f incoming;                  // unit, towards the viewer
  RayKind ray;
  const Textures* textures;

  const Vec3f& in(const Operation& o, size_t i) const { return registers[o.in[i]]; }
  float number(const Operation& o, size_t i) const { return registers[o.in[i]].x; }
  void set(const Operation& o, const Vec3f& value) { registers[o.out] = value; }
  void set(const Operation& o, float value) { registers[o.out] = {value, value, value}; }
  void set_second(const Operation& o, float value) { registers[o.out + 1] = {value, value, value}; }
  void set_second(const Operation& o, const Vec3f& value) { registers[o.out + 1] = value; }
  const SurfaceSample& surface(const Operation& o) const { return at[o.shift]; }
};

/// What an operation's `data` is: any number, or a place in the tables, or an image's number.
enum class DataKind : uint8_t { kNumber, kMatrix, kRamp, kCurves, kImage };

/// An operation by its name. `pure`: the result depends on the inputs alone, so that constants can be folded.
struct NamedOperation {
  const char* name;
  OperationFunction function;
  bool pure = true;
  DataKind data = DataKind::kNumber;
  bool looks_at_viewer = false;  // the result depends on where the surface is seen from

  /// Whether `data` names a whole table, or one of so many images.
  bool fits(int32_t data, std::span<const float> tables, size_t images) const;
};

/// The families, each in a file of its own.
std::span<const NamedOperation> input_operations();
std::span<const NamedOperation> math_operations();
std::span<const NamedOperation> vector_operations();
std::span<const NamedOperation> colour_operations();
std::span<const NamedOperation> mix_operations();
std::span<const NamedOperation> procedural_operations();
std::span<const NamedOperation> image_operations();

}  // namespace penumbra
