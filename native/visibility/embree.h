// SPDX-License-Identifier: GPL-3.0-or-later
// The one header that knows which Embree this is: versions 3 and 4 behind the same few functions.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <memory>
#include <string>
#include <type_traits>

#include "scene/memory_limit.h"

namespace penumbra {
class Geometry;
}

namespace penumbra::embree {

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release>;
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, Release>;

/// A device that throws std::runtime_error (or std::bad_alloc) at check_errors() after anything went wrong.
Device make_device();
void check_errors(RTCDevice device, const std::string& what);

/// A device whose memory is counted: where it exceeds the limit (bytes, 0: none), Embree fails.
struct CountedDevice {
  explicit CountedDevice(uint64_t limit = 0);
  CountedDevice(const CountedDevice&) = delete;
  CountedDevice& operator=(const CountedDevice&) = delete;

  /// Throws MemoryLimitReached, std::runtime_error or std::bad_alloc if anything went wrong in building
  /// `what`.
  void check_build(const std::string& what);

  MemoryCount memory;  // outlives the device, which reports to it
  Device device;
};

/// Throws std::runtime_error with a sentence if the Embree in this process is not the one this module was
/// built for, or does not find a ray's hit: another copy loaded first may answer our calls in silence.
void self_test();

/// The version of the library in this process, such as "3.13.5".
std::string version();

#if RTC_VERSION_MAJOR >= 4

inline void intersect16(const int* valid, RTCScene scene, RTCRayHit16& rays, bool coherent) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
  rtcIntersect16(valid, scene, &rays, &arguments);
}

/// The context of shadow rays, with what transparent surfaces leave of each ray's light, and that light's
/// channel: by the rays' `id`.
struct ShadowContext : RTCRayQueryContext {
  const Geometry* geometry;
  float* transmittance;
  const uint8_t* channels;
};

inline void occluded16(const int* valid, RTCScene scene, RTCRay16& rays, const Geometry* geometry,
                       float* transmittance, const uint8_t* channels, bool coherent) {
  ShadowContext context;
  rtcInitRayQueryContext(&context);
  context.geometry = geometry;
  context.transmittance = transmittance;
  context.channels = channels;
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context;
  arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
  rtcOccluded16(valid, scene, &rays, &arguments);
}

inline void intersect1(RTCScene scene, RTCRayHit& ray) {
  rtcIntersect1(scene, &ray, nullptr);
}

#else

inline void intersect16(const int* valid, RTCScene scene, RTCRayHit16& rays, bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcIntersect16(valid, scene, &context, &rays);
}

/// The context of shadow rays, with what transparent surfaces leave of each ray's light, and that light's
/// channel: by the rays' `id`.
struct ShadowContext : RTCIntersectContext {
  const Geometry* geometry;
  float* transmittance;
  const uint8_t* channels;
};

inline void occluded16(const int* valid, RTCScene scene, RTCRay16& rays, const Geometry* geometry,
                       float* transmittance, const uint8_t* channels, bool coherent) {
  ShadowContext context;
  rtcInitIntersectContext(&context);
  context.geometry = geometry;
  context.transmittance = transmittance;
  context.channels = channels;
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcOccluded16(valid, scene, &context, &rays);
}

inline void intersect1(RTCScene scene, RTCRayHit& ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray);
}

#endif

}  // namespace penumbra::embree
