// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/film.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <new>
#include <stdexcept>

namespace penumbra {

namespace {

/// Cryptomatte's: a kind and two digits.
bool is_matte(const std::string& name) {
  if (name.size() < 2) return false;
  const std::string kind = name.substr(0, name.size() - 2);
  return (kind == "CryptoObject" || kind == "CryptoMaterial" || kind == "CryptoAsset") &&
         std::isdigit(name[name.size() - 2]) && std::isdigit(name[name.size() - 1]);
}

}  // namespace

uint32_t pass_channels(const std::string& name) {
  static const std::map<std::string, uint32_t> channels{
      {"Combined", 4},      {"Depth", 1},           {"Normal", 3},         {"Position", 3},
      {"Light Samples", 1}, {"Error Estimate", 1},  {"Diffuse Direct", 3}, {"Diffuse Color", 3},
      {"Glossy Direct", 3}, {"Glossy Indirect", 3}, {"Glossy Color", 3},   {"Emission", 3},
      {"Environment", 3},   {"Shadow", 3},          {"Mist", 1},           {"UV", 3},
      {"Object Index", 1},  {"Material Index", 1}};
  const auto found = channels.find(name);
  if (found != channels.end()) return found->second;
  if (name.size() > kLightGroupPrefix.size() && name.starts_with(kLightGroupPrefix)) return 3;
  return is_matte(name) ? 4 : 0;
}

FilmPass::FilmPass(size_t size)
    : values_(static_cast<float*>(std::calloc(size, sizeof(float)))), size_(size) {
  if (size > 0 && !values_) throw std::bad_alloc();
}

Film::Film(const Rectangle& region, const std::vector<std::string>& passes) : region_(region) {
  const size_t pixels = size_t(region.width) * region.height;
  for (const std::string& name : passes) passes_[name] = FilmPass(pixels * pass_channels(name));
  passes_["Error Estimate"] = FilmPass(pixels);
  combined_ = find("Combined");
  depth_ = find("Depth");
  normal_ = find("Normal");
  position_ = find("Position");
  light_samples_ = find("Light Samples");
  error_estimate_ = find("Error Estimate");
}

uint64_t Film::bytes(const Rectangle& region, const std::vector<std::string>& passes) {
  uint64_t channels = pass_channels("Error Estimate");
  for (const std::string& name : passes) channels += pass_channels(name);
  return uint64_t(region.width) * region.height * channels * sizeof(float);
}

float* Film::find(const std::string& name) {
  const auto found = passes_.find(name);
  return found == passes_.end() ? nullptr : found->second.values().data();
}

std::span<const float> Film::pass(const std::string& name) const {
  const auto found = passes_.find(name);
  if (found == passes_.end()) throw std::invalid_argument("the pass '" + name + "' was not rendered");
  return found->second.values();
}

template <typename Passes, typename Visit>
void Film::for_each_row(Passes& passes, const Rectangle& area, const Visit& visit) const {
  for (auto& [name, pass] : passes) {
    const size_t channels = pass_channels(name);
    for (uint32_t y = area.y - region_.y; y < area.y - region_.y + area.height; ++y)
      visit(pass.values().data() + (size_t(y) * region_.width + (area.x - region_.x)) * channels,
            area.width * channels);
  }
}

std::vector<float> Film::copy(const Rectangle& area) const {
  std::vector<float> values;
  for_each_row(passes_, area, [&](const float* row, size_t n) { values.insert(values.end(), row, row + n); });
  return values;
}

void Film::paste(const Rectangle& area, const std::vector<float>& values) {
  auto next = values.begin();
  for_each_row(passes_, area, [&](float* row, size_t n) {
    std::copy(next, next + std::ptrdiff_t(n), row);
    next += std::ptrdiff_t(n);
  });
}

bool Film::write(uint32_t x, uint32_t y, const PixelValues& values) {
  const size_t pixel = size_t(y - region_.y) * region_.width + (x - region_.x);
  bool clean = true;
  const auto store = [&](float* pass, uint32_t channels, std::initializer_list<double> numbers) {
    if (!pass) return;
    float* out = pass + pixel * channels;
    for (double number : numbers) {
      const float rounded = float(number);
      clean = clean && std::isfinite(rounded);
      *out++ = std::isfinite(rounded) ? rounded : 0.0f;
    }
  };
  const auto store3 = [&](float* pass, const Vec3d& v) { store(pass, 3, {v.x, v.y, v.z}); };
  const double alpha = std::clamp(values.alpha, 0.0, 1.0);  // a surface may pass on more than it gets
  store(combined_, 4, {values.combined.x, values.combined.y, values.combined.z, alpha});
  store(depth_, 1, {values.depth});
  store3(normal_, values.normal);
  store3(position_, values.position);
  store(light_samples_, 1, {values.light_samples});
  store(error_estimate_, 1, {values.error_estimate});
  return !clean;
}

}  // namespace penumbra
