// SPDX-License-Identifier: GPL-3.0-or-later
// What part of a rectangular luminaire does a point see? Answered by chords: on each, what triangles hide is
// known exactly, as intervals, and so is the light of the rest. Lines instead of points, as in Barringer,
// Gribel and Akenine-Moller, "High-quality curve rendering using line sampled visibility", 2012, and Billen
// and Dutre, "Line sampling for direct illumination", 2016.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "visibility/occluder_tree.h"

namespace penumbra {

/// Integrals over the luminaire's area of cos cos' / r^2, up to a constant: without and with visibility.
struct ChordSums {
  double all = 0, seen = 0;

  friend ChordSums operator+(const ChordSums& a, const ChordSums& b) {
    return {a.all + b.all, a.seen + b.seen};
  }
};

/// Chords of one luminaire seen from one point; memory to use again for the next.
class Chords {
 public:
  static constexpr uint32_t kMost = 128;  // at a time

  /// Finds the occluders; false if there are more than `most`.
  bool look(const OccluderTree& tree, const LuminaireView& view, uint32_t most);
  uint32_t occluders() const { return uint32_t(occluders_.size()); }

  /// Sums over `count` evenly spaced chords, kMost at most: over every fourth, from the first, the second and
  /// so on; offset: of the first from the parallelogram's corner, 0 ... 1 distances. Nothing where they are
  /// beyond what is kept of a chord or single precision.
  std::optional<std::array<ChordSums, 4>> sum(uint32_t count, float offset);

 private:
  struct Intervals {
    static constexpr uint32_t kMost = 64;
    float begin[kMost], end[kMost];
  };
  void place(uint32_t count, float offset);
  bool cut();
  std::optional<std::array<ChordSums, 4>> weigh();

  LuminaireView view_;
  std::vector<Occluder> occluders_;
  uint32_t count_ = 0;
  float first_ = 0, step_ = 0;  // tau of chord i: first + i step
  static constexpr uint32_t kLanes = 8;
  alignas(64) float tau_[kMost + kLanes], begin_[kMost + kLanes], end_[kMost + kLanes];
  uint32_t interval_count_[kMost], room_[kMost];
  std::unique_ptr<Intervals[]> hidden_;  // of each chord
};

}  // namespace penumbra
