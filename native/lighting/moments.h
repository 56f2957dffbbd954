// SPDX-License-Identifier: GPL-3.0-or-later
// Running sums of a luminaire's points, in double, from which any colour's mean and variance follow.
#pragma once

#include <algorithm>
#include <cstdint>

#include "math/vector.h"
#include "sampling/sampler.h"

namespace penumbra {

/// Sums of a and of a * b over whole packets: lane by lane, then as a fixed tree.
struct PacketSums {
  double a, ab;
};
PacketSums sum_packets(const float* a, const float* b, uint32_t packets);

/// Sums over light points of the two lobes, diffuse f and Phong p (see LightPoints, evaluate_phong).
struct Moments {
  double count = 0, f = 0, p = 0, ff = 0, fp = 0, pp = 0;

  /// Adds points [0, n). Whole packets are summed as a fixed tree, fewer points one by one: the order, and so
  /// the result, depends on the caller's spans alone. `phong` may be null: no such lobe.
  void add(const float* diffuse, const float* phong, uint32_t n) {
    count += n;
    sum(diffuse, diffuse, n, f, ff);
    if (!phong) return;
    double unused = 0;
    sum(phong, phong, n, p, pp);
    sum(diffuse, phong, n, unused, fp);
  }

  /// Mean of diffuse_color * f + phong_color * p.
  Vec3d mean(const Vec3d& diffuse_color, const Vec3d& phong_color) const {
    return (diffuse_color * f + phong_color * p) / count;
  }

  /// Sample variance of that mean, V / n with Bessel's correction, as for independent points.
  Vec3d variance_of_mean(const Vec3d& d, const Vec3d& s) const {
    if (count < 2) return {};
    const double vf = ff - f * f / count, vp = pp - p * p / count, covariance = fp - f * p / count;
    const Vec3d v = (d * d * vf + d * s * (2 * covariance) + s * s * vp) / (count * (count - 1));
    return {std::max(v.x, 0.0), std::max(v.y, 0.0), std::max(v.z, 0.0)};
  }

 private:
  /// first += sum of a, second += sum of a * b.
  static void sum(const float* a, const float* b, uint32_t n, double& first, double& second) {
    const uint32_t packets = n / kPacket;
    if (packets) {
      const PacketSums sums = sum_packets(a, b, packets);
      first += sums.a;
      second += sums.ab;
    }
    for (uint32_t i = packets * kPacket; i < n; ++i) {
      first += double(a[i]);
      second += double(a[i]) * double(b[i]);
    }
  }
};

}  // namespace penumbra
