// SPDX-License-Identifier: GPL-3.0-or-later
// Things at evenly spaced times of the shutter, from its opening at 0 to its closing at 1, linear in between.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "math/transform.h"

namespace penumbra {

/// Where a time lies among `count` of them, at least two: between `first` and the next one.
struct TimeSegment {
  size_t first;
  double share;

  TimeSegment(double time, size_t count) {
    const double at = std::clamp(time, 0.0, 1.0) * double(count - 1);
    first = std::min(size_t(at), count - 2);
    share = at - double(first);
  }
};

template <typename T>
T mixed(const T& a, const T& b, double share) {
  return a * (1 - share) + b * share;
}

template <>
inline Affine mixed(const Affine& a, const Affine& b, double share) {
  return {mixed(a.x_axis, b.x_axis, share), mixed(a.y_axis, b.y_axis, share),
          mixed(a.z_axis, b.z_axis, share), mixed(a.origin, b.origin, share)};
}

/// The value at a time; `still` where there is no motion.
template <typename T>
T at_time(const std::vector<T>& motion, const T& still, double time) {
  if (motion.empty()) return still;
  const TimeSegment segment(time, motion.size());
  return mixed(motion[segment.first], motion[segment.first + 1], segment.share);
}

/// More poses between the given ones, as many as it takes for each to be turned by a few degrees at most: a
/// turn at even speed about one axis, as Cycles interpolates, which straight lines then follow within 4e-4 of
/// the radius. At most 129, Embree's limit.
std::vector<Affine> subdivided(const std::vector<Affine>& poses);

}  // namespace penumbra
