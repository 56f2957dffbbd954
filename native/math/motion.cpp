// SPDX-License-Identifier: GPL-3.0-or-later
#include "math/motion.h"

#include <cmath>
#include <numbers>

namespace penumbra {
namespace {

constexpr double kMostTurn = 3 * std::numbers::pi / 180;
constexpr size_t kMostPoses = 129;

/// Orthonormal axes along x, and in the plane of x and y; none where those have no area.
bool frame_of(const Affine& pose, Affine& frame) {
  const Vec3d z = cross(pose.x_axis, pose.y_axis);
  if (dot(z, z) == 0) return false;
  frame.x_axis = normalize(pose.x_axis);
  frame.z_axis = normalize(z);
  frame.y_axis = cross(frame.z_axis, frame.x_axis);
  return true;
}

Vec3d turned(const Vec3d& v, const Vec3d& axis, double angle) {  // Rodrigues
  const double c = std::cos(angle), s = std::sin(angle);
  return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1 - c));
}

/// From one pose to the next: a turn of the frame, the rest of the transform seen from it straight.
struct Turn {
  Affine from_frame, from_rest, to_rest;
  Vec3d axis;
  double angle = 0;

  Turn(const Affine& from, const Affine& to) {
    Affine to_frame;
    if (!frame_of(from, from_frame) || !frame_of(to, to_frame)) return;
    const Vec3d* f[3] = {&from_frame.x_axis, &from_frame.y_axis, &from_frame.z_axis};
    const Vec3d* t[3] = {&to_frame.x_axis, &to_frame.y_axis, &to_frame.z_axis};
    // The rotation that carries f to t: twice the sine times its axis, and its trace 1 + 2 cos.
    Vec3d twice_sine;
    double trace = 0;
    for (int i = 0; i < 3; ++i) {
      twice_sine += cross(*f[i], *t[i]);
      trace += dot(*f[i], *t[i]);
    }
    angle = std::atan2(length(twice_sine), trace - 1);
    axis = normalize(twice_sine);
    // Half a turn has no axis in the sine: it is the largest column of R + 1.
    if (dot(axis, axis) == 0 && trace < 0) {
      for (int i = 0; i < 3; ++i) {
        const Vec3d column = *f[i] + *t[i];
        if (dot(column, column) > dot(axis, axis)) axis = column;
      }
      axis = normalize(axis);
    }
    from_rest = seen_from(from_frame, from);
    to_rest = seen_from(to_frame, to);
  }

  static Affine seen_from(const Affine& frame, const Affine& pose) {
    const auto local = [&](const Vec3d& v) {
      return Vec3d{dot(frame.x_axis, v), dot(frame.y_axis, v), dot(frame.z_axis, v)};
    };
    return {local(pose.x_axis), local(pose.y_axis), local(pose.z_axis), {}};
  }

  Affine at(double share, const Vec3d& origin) const {
    Affine frame{turned(from_frame.x_axis, axis, share * angle),
                 turned(from_frame.y_axis, axis, share * angle),
                 turned(from_frame.z_axis, axis, share * angle), origin};
    return frame * mixed(from_rest, to_rest, share);
  }
};

}  // namespace

std::vector<Affine> subdivided(const std::vector<Affine>& poses) {
  if (poses.size() < 2) return {};
  std::vector<Turn> turns;
  double most = 0;
  for (size_t i = 0; i + 1 < poses.size(); ++i) {
    turns.emplace_back(poses[i], poses[i + 1]);
    most = std::max(most, turns.back().angle);
  }
  const size_t steps = std::clamp<size_t>(size_t(std::ceil(most / kMostTurn)), 1,
                                          std::max<size_t>((kMostPoses - 1) / turns.size(), 1));
  std::vector<Affine> result;
  for (size_t i = 0; i < turns.size(); ++i) {
    result.push_back(poses[i]);
    for (size_t k = 1; k < steps; ++k) {
      const double share = double(k) / double(steps);
      result.push_back(turns[i].at(share, mixed(poses[i].origin, poses[i + 1].origin, share)));
    }
  }
  result.push_back(poses.back());
  return result;
}

}  // namespace penumbra
