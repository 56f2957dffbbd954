// SPDX-License-Identifier: GPL-3.0-or-later
// A material's node tree, compiled: a list of operations on registers, and closures made of registers.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "math/vector.h"

namespace penumbra {

struct Machine;
struct Operation;
using OperationFunction = void (*)(Machine&, const Operation&);

/// One step: reads registers, writes register `out` (some also the next one). A register holds three floats;
/// a number is held three times.
struct Operation {
  static constexpr size_t kMaxInputs = 8;
  OperationFunction function;
  std::array<uint16_t, kMaxInputs> in;
  uint16_t out;
  uint16_t shift;  // evaluate the surface here (0), or one footprint to the side (1, 2), for bumps
  int32_t data;    // of the operation's own: an attribute, a texture, a place in `tables`
};

enum class ClosureKind : uint8_t {
  kDiffuse,
  kDisney,
  kSheen,
  kGlossy,
  kCorrelatedGlossy,
  kBeckmann,
  kClearcoat,
  kPhong,
  kEmission,
  kTransparent,
  kHoldout
};

constexpr bool is_microfacets(ClosureKind kind) {
  return kind >= ClosureKind::kGlossy && kind <= ClosureKind::kClearcoat;
}

/// Inputs of a closure: registers. See Lobe; unused ones name register 0, which is zero.
struct ClosureStep {
  ClosureKind kind;
  uint16_t colour;     // the product of the mixing factors included
  uint16_t edge, ior;  // of microfacets
  uint16_t roughness;  // Blender's own; kPhong: exponent
};

struct Program {
  std::vector<Vec3f> registers;  // initial values: the constants
  std::vector<Operation> operations;
  std::vector<float> tables;  // of colour ramps and the like
  std::vector<ClosureStep> closures;
  bool looks_beside = false;       // some operation has a shift
  bool looks_at_viewer = false;    // some operation depends on where the surface is seen from
  bool grey_transparency = false;  // what goes through is the same for red, green and blue
  bool facet_bumps = false;        // see Closures::facet_bumps
  uint16_t normal = 0;             // register with the shading normal, world space; 0: the surface's own

  bool has(ClosureKind kind) const {
    return std::any_of(closures.begin(), closures.end(), [kind](const auto& c) { return c.kind == kind; });
  }
  bool may_mirror() const {
    return std::any_of(closures.begin(), closures.end(),
                       [](const auto& c) { return is_microfacets(c.kind); });
  }
  bool may_be_glossy() const { return may_mirror() || has(ClosureKind::kPhong); }
};

}  // namespace penumbra
