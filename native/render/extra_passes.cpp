// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/extra_passes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace penumbra {
namespace {

/// Passes that every film may have; not this class's.
bool is_basic(const std::string& name) {
  return name == "Combined" || name == "Depth" || name == "Normal" || name == "Position" ||
         name == "Light Samples" || name == "Error Estimate";
}

/// Light by colour, channel by channel. A channel without colour takes the mean of the others, as in Cycles.
Vec3d divided(const Vec3d& light, const Vec3d& colour) {
  double sum = 0;
  int defined = 0;
  for (int i = 0; i < 3; ++i) {
    if (colour[i] == 0) continue;
    sum += light[i] / colour[i];
    ++defined;
  }
  if (defined == 0) return {};
  const auto channel = [&](int i) { return colour[i] != 0 ? light[i] / colour[i] : sum / defined; };
  return {channel(0), channel(1), channel(2)};
}

/// The attribute's value at a surface point; false if its mesh has none.
bool interpolate(const SurfacePlace& place, uint32_t attribute, double* out) {
  if (!place.attributes) return false;
  for (const Attribute& one : *place.attributes) {
    if (one.name != attribute) continue;
    const auto* corners = &one.corners[3 * size_t(place.triangle)];
    for (size_t i = 0; i < 2; ++i)
      out[i] = double(corners[0][i]) * (1 - place.u - place.v) + double(corners[1][i]) * place.u +
               double(corners[2][i]) * place.v;
    return true;
  }
  return false;
}

}  // namespace

ExtraPasses::ExtraPasses(const std::vector<std::string>& names, const Scene& scene, const Geometry& geometry,
                         Film& film)
    : scene_(scene), geometry_(geometry), region_(film.region()) {
  for (const std::string& name : names) {
    if (is_basic(name)) continue;
    Pass pass = pass_of(name);
    pass.pixels = film.find(name);
    pass.channels = pass_channels(name);
    passes_.push_back(pass);
    want_mattes_ = want_mattes_ || pass.kind == Kind::kMatte;
    want_parts_ = want_parts_ || pass.kind <= Kind::kMist;
  }
}

ExtraPasses::Pass ExtraPasses::pass_of(const std::string& name) const {
  static const std::map<std::string, Pass> known{
      {"Diffuse Direct", {Kind::kLight, kDiffuseLight, kDiffuseColour}},
      {"Diffuse Color", {Kind::kPart, kDiffuseColour}},
      {"Glossy Direct", {Kind::kLight, kGlossyLight, kGlossyColour}},
      {"Glossy Indirect", {Kind::kLight, kMirroredLight, kGlossyColour}},
      {"Glossy Color", {Kind::kPart, kGlossyColour}},
      {"Emission", {Kind::kPart, kEmission}},
      {"Environment", {Kind::kPart, kEnvironment}},
      {"Shadow", {Kind::kShadow}},
      {"Mist", {Kind::kMist}},
      {"UV", {Kind::kUv}},
      {"Object Index", {Kind::kObjectIndex}},
      {"Material Index", {Kind::kMaterialIndex}}};
  static const std::map<std::string, Matte> mattes{
      {"CryptoObject", Matte::kObject}, {"CryptoMaterial", Matte::kMaterial}, {"CryptoAsset", Matte::kAsset}};
  if (const auto found = known.find(name); found != known.end()) return found->second;
  if (name.starts_with(kLightGroupPrefix)) {
    const std::vector<std::string>& groups = scene_.light_groups();
    const auto group = std::find(groups.begin(), groups.end(), name.substr(kLightGroupPrefix.size()));
    if (group != groups.end()) return {Kind::kPart, kFirstGroup + uint32_t(group - groups.begin())};
    throw std::invalid_argument("the scene has no light group for the pass '" + name + "'");
  }
  Pass pass{Kind::kMatte};
  pass.matte = mattes.at(name.substr(0, name.size() - 2));
  pass.level = uint32_t(std::stoul(name.substr(name.size() - 2)));
  return pass;
}

std::vector<ExtraPasses::Rank> ExtraPasses::ranks(Matte matte, const PixelParts& pixel) const {
  std::vector<Rank> result;
  for (const MatteHit& hit : pixel.mattes) {
    const ObjectTraits& traits = geometry_.traits_of(hit.instance);
    const float id = matte == Matte::kObject     ? traits.object_matte
                     : matte == Matte::kMaterial ? scene_.materials()[hit.material].matte
                                                 : traits.asset_matte;
    const auto same = std::find_if(result.begin(), result.end(), [id](const Rank& r) { return r.id == id; });
    if (same != result.end())
      same->coverage += hit.weight / pixel.samples;
    else
      result.push_back({id, hit.weight / pixel.samples});
  }
  std::sort(result.begin(), result.end(), [](const Rank& a, const Rank& b) {
    return a.coverage != b.coverage ? a.coverage > b.coverage : a.id < b.id;
  });
  return result;
}

void ExtraPasses::value(const Pass& pass, const SeenObject& seen, const PixelParts& pixel,
                        double* out) const {
  const auto store = [out](const Vec3d& v) { out[0] = v.x, out[1] = v.y, out[2] = v.z; };
  const bool hit = seen.instance != Hit::kNone;
  switch (pass.kind) {
    case Kind::kPart:
      return store(pixel.parts[pass.part]);
    case Kind::kLight:
      return store(divided(pixel.parts[pass.part], pixel.parts[pass.colour]));
    case Kind::kShadow:
      return store(divided(pixel.parts[kShadowedLight], pixel.parts[kUnshadowedLight]));
    case Kind::kMist:
      out[0] = 1 - pixel.parts[kClearness].x;
      return;
    case Kind::kUv:
      if (scene_.uv_attribute() && interpolate(seen.place, *scene_.uv_attribute(), out)) out[2] = 1;
      return;
    case Kind::kObjectIndex:
      out[0] = hit ? double(geometry_.traits_of(seen.instance).pass_index) : 0;
      return;
    case Kind::kMaterialIndex:
      out[0] = hit ? double(scene_.materials()[seen.material].pass_index) : 0;
      return;
    case Kind::kMatte: {
      const std::vector<Rank> all = ranks(pass.matte, pixel);
      for (uint32_t i = 0; i < 2 && 2 * pass.level + i < all.size(); ++i) {
        out[2 * i] = double(all[2 * pass.level + i].id);
        out[2 * i + 1] = all[2 * pass.level + i].coverage;
      }
    }
  }
}

bool ExtraPasses::write(uint32_t x, uint32_t y, const SeenObject& seen, const PixelParts& pixel) const {
  const size_t at = size_t(y - region_.y) * region_.width + (x - region_.x);
  bool clean = true;
  for (const Pass& pass : passes_) {
    double values[4] = {};
    value(pass, seen, pixel, values);
    for (uint32_t i = 0; i < pass.channels; ++i) {
      const float rounded = float(values[i]);
      clean = clean && std::isfinite(rounded);
      pass.pixels[at * pass.channels + i] = std::isfinite(rounded) ? rounded : 0.0f;
    }
  }
  return !clean;
}

}  // namespace penumbra
