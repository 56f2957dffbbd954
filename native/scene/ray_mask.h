// SPDX-License-Identifier: GPL-3.0-or-later
// Which rays an object is there for.
#pragma once

#include <cstdint>

namespace penumbra {

/// Kinds of rays, a bit each: rays of a kind meet the instances that have its bit.
using RayMask = uint32_t;

inline constexpr RayMask kCameraRay = 1, kMirrorRay = 2, kShadowRay = 4, kAnyRay = ~RayMask{0};

/// Shadow rays where what is in the way is the same for red, green and blue, or where that does not matter.
inline constexpr uint8_t kAllChannels = 3;

/// What a luminaire's shadow rays are.
struct ShadowKind {
  RayMask mask = kShadowRay;
  uint8_t channel = kAllChannels;  // 0, 1, 2: of red, green or blue light alone
};

/// Shadow rays of luminaires that some objects alone hide: a kind for each such set of objects.
inline constexpr uint32_t kMostBlockerSets = 29;
constexpr RayMask blocker_set_ray(uint32_t set) {
  return RayMask{8} << set;
}

}  // namespace penumbra
