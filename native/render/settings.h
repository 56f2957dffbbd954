// SPDX-License-Identifier: GPL-3.0-or-later
// What a render is asked for. Names and defaults are those of the add-on's settings.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lighting/bounded_light.h"
#include "lighting/stop_rule.h"
#include "render/pixel_filter.h"
#include "sampling/sampler.h"

namespace penumbra {

/// Pixels of the full frame, origin bottom left.
struct Rectangle {
  uint32_t x = 0, y = 0, width = 0, height = 0;
};

/// How much of what lies how far from the camera is mist: ((distance - start) / depth)^exponent.
struct MistSettings {
  double start = 5, depth = 25, exponent = 2;  // world units
};

struct RenderSettings {
  uint32_t width = 0, height = 0;  // full frame
  Rectangle region;                // what is rendered; all where its width is 0

  StopRuleKind stop_rule = StopRuleKind::kBounded;
  SamplerKind sampler = SamplerKind::kOwenSobol;
  SampleReuse sample_reuse = SampleReuse::kScrambled;
  uint32_t light_samples = 64;
  uint32_t max_light_samples = 8192;
  uint32_t check_interval = 5;
  uint32_t pixel_samples = 1;
  uint32_t max_pixel_samples = 8192;
  FilterKind filter_type = FilterKind::kBlackmanHarris;
  double filter_width = 1.5;  // see PixelFilter
  uint32_t mirror_depth = 4;
  uint32_t seed = 0;
  double error_tolerance = 0.004;  // display units
  double exposure = 0;             // stops: display = radiance x 2^exposure
  uint32_t threads = 0;            // 0: one for each processor
  std::vector<std::string> passes{"Combined"};
  MistSettings mist;
  uint32_t memory_limit = 0;  // MiB for the film and the ray tracing structure; 0: none
  std::string checkpoint;     // folder of finished buckets to go on from; none if empty
  std::string build;          // of the program: a checkpoint belongs to one

  /// Checks every setting and each combination; throws std::invalid_argument naming the settings. Returns a
  /// copy with the region filled in.
  RenderSettings validated() const;

  /// BOUNDED with antialiasing: pixel_samples above 1 only turns it on.
  bool filtered() const { return stop_rule == StopRuleKind::kBounded && pixel_samples > 1; }

  /// Everything that a pixel depends on, as text.
  std::string description() const;

  StopSettings stop_settings() const;
  BoundedSettings bounded_settings(const Geometry& geometry) const;
  SamplerSettings sampler_settings() const;
};

}  // namespace penumbra
