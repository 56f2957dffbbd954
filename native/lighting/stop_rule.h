// SPDX-License-Identifier: GPL-3.0-or-later
// Error-bounded luminaire sampling (EBLS): when are there enough points on a luminaire?
#pragma once

#include <cmath>

#include "lighting/moments.h"

namespace penumbra {

enum class StopRuleKind { kFixed, kPaper, kVariance, kBounded };

struct StopSettings {
  StopRuleKind kind = StopRuleKind::kPaper;
  uint32_t light_samples = 64;        // FIXED: how many
  uint32_t max_light_samples = 8192;  // the others: at most
  uint32_t check_interval = 5;        // t of PAPER
  double tolerance = 0.004;           // eps, in units of radiance

  uint32_t limit() const { return kind == StopRuleKind::kFixed ? light_samples : max_light_samples; }
};

/// Least number of points before VARIANCE trusts its estimate of a variance.
inline constexpr uint32_t kVarianceMinimum = 10;

/// Watches one luminaire's running mean at one shading point.
class StopRule {
 public:
  /// Colours: radiance x albedo of the two lobes, r, g, b.
  StopRule(const StopSettings& settings, const Vec3d& diffuse_color, const Vec3d& phong_color)
      : settings_(settings), diffuse_(diffuse_color), phong_(phong_color) {}

  /// Points until the rule wants to look again.
  uint32_t next_check(uint32_t count) const {
    switch (settings_.kind) {
      case StopRuleKind::kPaper:
        return settings_.check_interval;
      case StopRuleKind::kVariance:
        return count < kVarianceMinimum ? kVarianceMinimum - count : 1;
      default:
        return settings_.light_samples - count;
    }
  }

  /// Called after next_check() more points. PAPER: |mean_n - mean_(n-t)| < eps in each of r, g, b, first at
  /// n = 2t. VARIANCE: sqrt(V / n) < eps in each.
  bool enough(const Moments& moments) {
    switch (settings_.kind) {
      case StopRuleKind::kPaper: {
        const Vec3d mean = moments.mean(diffuse_, phong_);
        const bool agrees = has_previous_ && max_abs(mean - previous_) < settings_.tolerance;
        previous_ = mean;
        has_previous_ = true;
        return agrees;
      }
      case StopRuleKind::kVariance:
        return std::sqrt(max_component(moments.variance_of_mean(diffuse_, phong_))) < settings_.tolerance;
      default:
        return true;
    }
  }

 private:
  StopSettings settings_;
  Vec3d diffuse_, phong_, previous_;
  bool has_previous_ = false;
};

}  // namespace penumbra
