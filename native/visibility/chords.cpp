// SPDX-License-Identifier: GPL-3.0-or-later
#include "visibility/chords.h"

#include <algorithm>
#include <cmath>

#include "math/arc_tangent.h"
#include "math/simd.h"

namespace penumbra {
namespace {

/// Intervals of a chord are sorted and united when there are so many new ones.
constexpr uint32_t kNew = 16;

/// Sorts intervals and unites those that touch; returns how many there are then.
uint32_t unite(float* begin, float* end, uint32_t count) {
  if (count == 0) return 0;
  for (uint32_t i = 1; i < count; ++i) {
    const float b = begin[i], e = end[i];
    uint32_t j = i;
    for (; j > 0 && begin[j - 1] > b; --j) begin[j] = begin[j - 1], end[j] = end[j - 1];
    begin[j] = b, end[j] = e;
  }
  uint32_t last = 0;
  for (uint32_t i = 1; i < count; ++i) {
    if (begin[i] <= end[last]) {
      end[last] = std::max(end[last], end[i]);
    } else {
      ++last;
      begin[last] = begin[i], end[last] = end[i];
    }
  }
  return last + 1;
}

/// Which of a chord's 64 equal cells a place is in; beyond its ends the nearest.
inline int cell(float place) {
  return place > 0 ? (place < 63.0f / 64 ? int(place * 64) : 63) : 0;
}

/// Cells that an interval touches.
inline uint64_t cells(float begin, float end) {
  return (~uint64_t{0} << cell(begin)) & (~uint64_t{0} >> (63 - cell(end)));
}

/// Cells that lie in one of the intervals. What is in full cells alone is hidden already.
uint64_t full_cells(const float* begin, const float* end, uint32_t count) {
  uint64_t full = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const int first = int(std::ceil(begin[i] * 64)), last = int(end[i] * 64) - 1;
    if (first <= last) full |= (~uint64_t{0} << first) & (~uint64_t{0} >> (63 - last));
  }
  return full;
}

/// What light along chords needs to know of the view: products of the surface's normal n, the way d to the
/// corner, the edge v and the chords' direction g.
struct ChordLight {
  double nd, nv, ng, dd, dv, vv, dg, vg, gg;

  explicit ChordLight(const LuminaireView& view) {
    const Vec3d n(view.normal), d(view.corner), v(view.edge_v),
        g = Vec3d(view.edge_u) + v * double(view.skew);
    nd = dot(n, d), nv = dot(n, v), ng = dot(n, g), dd = dot(d, d), dv = dot(d, v), vv = dot(v, v),
    dg = dot(d, g), vg = dot(v, g), gg = dot(g, g);
  }
};

/// Integrals of n x / |x|^4 for x = d + tau v + s g over s in begin ... end: of (a + b s) / (A s^2 + 2 B s +
/// C)^2, D = A C - B^2, in differences that do not cancel where the interval is short.
PENUMBRA_VECTORIZED
void integrate(const ChordLight& terms, uint32_t count, const double* tau, const double* begin,
               const double* end, double* __restrict out) {
  const ChordLight q = terms;
  for (uint32_t i = 0; i < count; ++i) {
    const double t = tau[i];
    const double a = q.nd + t * q.nv, b = q.ng, A = q.gg, B = q.dg + t * q.vg,
                 C = q.dd + t * (2 * q.dv + t * q.vv);
    const double D = A * C - B * B, root = std::sqrt(D), length = end[i] - begin[i];
    const double x = A * begin[i] + B, y = A * end[i] + B;
    const double scale = A * A / ((x * x + D) * (y * y + D));  // 1 / the product of both denominators
    const double angle = angle_of(root * A * length, D + x * y);
    const double even = (length * (D - x * y) * scale + A / root * angle) / (2 * D);
    const double odd = length * (x + y) * scale / (2 * A);
    out[i] = b * odd + (a - b * B / A) * even;
  }
}

/// Where on chords a triangle's four functions are all positive, from `from` to `to`.
template <uint32_t kLanes>
inline void find_hidden(const Occluder& occluder, const float* tau, const float* begin, const float* end,
                        float* from, float* to) {
  for (uint32_t i = 0; i < kLanes; ++i) {
    float low = begin[i], high = end[i];
    for (int f = 0; f < 4; ++f) {
      const float zero = (occluder.constant[f] + occluder.slope[f] * tau[i]) * occluder.inverse[f];
      const float below = zero + occluder.lower[f], above = zero + occluder.upper[f];
      low = low > below ? low : below;
      high = high < above ? high : above;
    }
    from[i] = low, to[i] = high;
  }
}

}  // namespace

bool Chords::look(const OccluderTree& tree, const LuminaireView& view, uint32_t most) {
  view_ = view;
  return tree.find(view, most, occluders_);
}

/// The parts of chords in the parallelogram and above the surface's horizon.
void Chords::place(uint32_t count, float offset) {
  count_ = count;
  const float skew = view_.skew;
  step_ = (1 + skew) / float(count);
  first_ = offset * step_ - skew;
  const Vec3d n(view_.normal);
  const double corner = dot(n, Vec3d(view_.corner)), across = dot(n, Vec3d(view_.edge_v)),
               along = dot(n, Vec3d(view_.edge_u)) + double(view_.skew) * across;
  for (uint32_t i = 0; i < count; ++i) {
    const float tau = first_ + float(i) * step_;
    float begin = std::max(0.0f, -tau / skew), end = std::min(1.0f, (1 - tau) / skew);
    const double height = corner + double(tau) * across;  // at s = 0
    const double horizon = std::clamp(-height / along, -1.0, 2.0);
    if (along > 0) begin = std::max(begin, float(horizon));
    if (along < 0) end = std::min(end, float(horizon));
    if (along == 0 && height <= 0) end = begin;
    tau_[i] = tau, begin_[i] = begin, end_[i] = std::max(begin, end);
  }
  std::fill_n(tau_ + count, kLanes, 0.0f), std::fill_n(begin_ + count, kLanes, 0.0f),
      std::fill_n(end_ + count, kLanes, 0.0f);
}

/// All intervals that triangles hide; false if too many are apart.
PENUMBRA_VECTORIZED
bool Chords::cut() {
  alignas(64) float from[kLanes], to[kLanes];
  std::fill_n(interval_count_, count_, 0u);
  std::fill_n(room_, count_, kNew);
  uint64_t full[kMost] = {};  // cells of each chord
  Intervals* hidden = hidden_.get();
  const float per_step = 1 / step_, last = float(count_ - 1);
  for (const Occluder& occluder : occluders_) {
    // Wider by what rounding may move: chords that a triangle does not meet find nothing.
    const float first = (occluder.first_tau - first_) * per_step - 1e-3f,
                end = (occluder.end_tau - first_) * per_step + 1e-3f;
    const int to_chord = int(std::clamp(end, -1.0f, last));
    for (int i = int(std::ceil(std::clamp(first, 0.0f, last + 1))); i <= to_chord; i += int(kLanes)) {
      find_hidden<kLanes>(occluder, tau_ + i, begin_ + i, end_ + i, from, to);
      const int lanes = std::min(to_chord - i + 1, int(kLanes));
      for (int k = 0; k < lanes; ++k) {
        Intervals& chord = hidden[i + k];
        uint32_t n = interval_count_[i + k];
        chord.begin[n] = from[k], chord.end[n] = to[k];
        n += (from[k] < to[k]) & ((cells(from[k], to[k]) & ~full[i + k]) != 0);
        if (n == room_[i + k]) {
          n = unite(chord.begin, chord.end, n);
          if (n == Intervals::kMost) return false;
          room_[i + k] = std::min(n + kNew, Intervals::kMost);
          full[i + k] = full_cells(chord.begin, chord.end, n);
        }
        interval_count_[i + k] = n;
      }
    }
  }
  return true;
}

/// Light of the whole chords, less that of their hidden parts.
std::optional<std::array<ChordSums, 4>> Chords::weigh() {
  constexpr uint32_t kBatch = 256;
  static_assert(kMost <= kBatch && Intervals::kMost <= kBatch);
  alignas(64) double tau[kBatch], begin[kBatch], end[kBatch], light[kBatch];
  uint8_t part[kBatch];
  const ChordLight terms(view_);
  double all[4] = {}, hidden[4] = {};
  uint32_t n = 0;
  const auto add_to = [&](double* sums) {
    if (n == 0) return;
    integrate(terms, n, tau, begin, end, light);
    for (uint32_t i = 0; i < n; ++i) sums[part[i]] += light[i];
    n = 0;
  };
  const auto put = [&](uint32_t chord, float from, float to) {
    tau[n] = double(tau_[chord]), begin[n] = double(from), end[n] = double(to), part[n++] = chord % 4;
  };
  for (uint32_t i = 0; i < count_; ++i)
    if (begin_[i] < end_[i]) put(i, begin_[i], end_[i]);
  add_to(all);
  for (uint32_t i = 0; i < count_; ++i) {
    Intervals& chord = hidden_[i];
    const uint32_t parts = unite(chord.begin, chord.end, interval_count_[i]);
    if (n + parts > kBatch) add_to(hidden);
    for (uint32_t k = 0; k < parts; ++k) put(i, chord.begin[k], chord.end[k]);
  }
  add_to(hidden);
  std::array<ChordSums, 4> sums;
  for (int k = 0; k < 4; ++k) {
    if (!std::isfinite(all[k] + hidden[k])) return std::nullopt;
    const double seen = std::clamp(all[k] - hidden[k], 0.0, all[k]);
    // A rounding error of what is hidden altogether is no light (ends of intervals at a corner that triangles
    // share).
    sums[k] = {all[k], seen < 1e-7 * all[k] ? 0 : seen};
  }
  return sums;
}

std::optional<std::array<ChordSums, 4>> Chords::sum(uint32_t count, float offset) {
  if (!hidden_) hidden_ = std::make_unique_for_overwrite<Intervals[]>(kMost);
  place(count, offset);
  return cut() ? weigh() : std::nullopt;
}

}  // namespace penumbra
