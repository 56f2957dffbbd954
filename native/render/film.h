// SPDX-License-Identifier: GPL-3.0-or-later
// The passes of the rendered region, as 32-bit floats. Row 0 is the bottom one, as in Blender.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/settings.h"

namespace penumbra {

/// What the names of light groups' passes begin with.
inline constexpr std::string_view kLightGroupPrefix = "Combined_";

/// Channels of a pass of that name; 0 where there is none.
uint32_t pass_channels(const std::string& name);

/// One pixel's values for every pass.
struct PixelValues {
  Vec3d combined;
  double alpha = 0;
  double depth = 0;        // along the view axis, world units; kNoDepth where nothing is hit
  Vec3d normal, position;  // world space; zero where nothing is hit
  double light_samples = 0;
  double error_estimate = 0;  // display units

  static constexpr double kNoDepth = 1e10;  // Blender's own value
};

/// Zeros at first. The system makes each page of them when a thread first writes there: one thread that
/// zeroed all of them beforehand took as long as three per cent of a render by two.
class FilmPass {
 public:
  FilmPass() = default;
  /// Throws std::bad_alloc.
  explicit FilmPass(size_t size);

  std::span<float> values() { return {values_.get(), size_}; }
  std::span<const float> values() const { return {values_.get(), size_}; }

 private:
  struct Free {
    void operator()(float* values) const { std::free(values); }
  };
  std::unique_ptr<float[], Free> values_;
  size_t size_ = 0;
};

class Film {
 public:
  /// The error estimate is always kept: statistics are made of it.
  Film(const Rectangle& region, const std::vector<std::string>& passes);

  /// What such a film takes.
  static uint64_t bytes(const Rectangle& region, const std::vector<std::string>& passes);

  /// x, y: full-frame pixel inside the region. Threads may write different pixels at the same time. A value
  /// that is not finite is written as zero; returns whether there was one.
  bool write(uint32_t x, uint32_t y, const PixelValues& values);

  const Rectangle& region() const { return region_; }
  bool has(const std::string& name) const { return passes_.count(name) > 0; }
  /// Width x height x channels values. Throws std::invalid_argument for a pass that was not asked for.
  std::span<const float> pass(const std::string& name) const;

  /// Its values; null where it was not asked for.
  float* find(const std::string& name);

  /// Every pass of some pixels (full frame, inside the region) one after the other; and back again.
  std::vector<float> copy(const Rectangle& area) const;
  void paste(const Rectangle& area, const std::vector<float>& values);

 private:
  /// Calls visit(first float, number of floats) for each row of the area in each pass.
  template <typename Passes, typename Visit>
  void for_each_row(Passes& passes, const Rectangle& area, const Visit& visit) const;

  Rectangle region_;
  std::map<std::string, FilmPass> passes_;
  float *combined_, *depth_, *normal_, *position_, *light_samples_, *error_estimate_;
};

}  // namespace penumbra
