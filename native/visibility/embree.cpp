// SPDX-License-Identifier: GPL-3.0-or-later
#include "visibility/embree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>

namespace penumbra::embree {
namespace {

const char* error_text(RTCError error) {
  switch (error) {
    case RTC_ERROR_INVALID_ARGUMENT:
      return "invalid argument";
    case RTC_ERROR_INVALID_OPERATION:
      return "invalid operation";
    case RTC_ERROR_OUT_OF_MEMORY:
      return "out of memory";
    case RTC_ERROR_UNSUPPORTED_CPU:
      return "this CPU is not supported";
    case RTC_ERROR_CANCELLED:
      return "cancelled";
    default:
      return "unknown error";
  }
}

bool ray_finds_triangle(RTCDevice device) {
  SceneHandle scene(rtcNewScene(device));
  RTCGeometry triangle = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(triangle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3));
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(triangle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), 1));
  if (!vertices || !indices) return false;
  const float corners[9] = {-1, -1, 0, 1, -1, 0, 0, 1, 0};
  std::copy(corners, corners + 9, vertices);
  for (unsigned i = 0; i < 3; ++i) indices[i] = i;
  rtcCommitGeometry(triangle);
  rtcAttachGeometry(scene.get(), triangle);
  rtcReleaseGeometry(triangle);
  rtcCommitScene(scene.get());

  RTCRayHit ray{};
  ray.ray.org_z = 1;
  ray.ray.dir_z = -1;
  ray.ray.tfar = std::numeric_limits<float>::infinity();
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  intersect1(scene.get(), ray);
  // Blender's own build of Embree 4.4.1 is an ulp off: 0.99999994.
  return ray.hit.geomID != RTC_INVALID_GEOMETRY_ID && std::abs(ray.ray.tfar - 1.0f) < 1e-5f;
}

}  // namespace

Device make_device() {
  Device device(rtcNewDevice(nullptr));
  if (!device)
    throw std::runtime_error(std::string("Embree made no device: ") + error_text(rtcGetDeviceError(nullptr)));
  return device;
}

void check_errors(RTCDevice device, const std::string& what) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return;
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  throw std::runtime_error("Embree, " + what + ": " + error_text(error));
}

CountedDevice::CountedDevice(uint64_t limit) : memory(limit), device(make_device()) {
  rtcSetDeviceMemoryMonitorFunction(
      device.get(),
      [](void* counter, ssize_t bytes, bool) { return static_cast<MemoryCount*>(counter)->add(bytes); },
      &memory);
}

void CountedDevice::check_build(const std::string& what) {
  if (memory.exceeded()) {
    rtcGetDeviceError(device.get());  // takes Embree's own word for it away
    throw MemoryLimitReached(memory.limit(), "building the ray tracing structure of " + what);
  }
  check_errors(device.get(), what);
}

std::string version() {
  const Device device = make_device();
  const auto number = rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_VERSION);
  return std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." +
         std::to_string(number % 100);
}

void self_test() {
  const Device device = make_device();
  const auto major = rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_VERSION) / 10000;
  if (major != RTC_VERSION_MAJOR)
    throw std::runtime_error("this module was built for Embree " + std::to_string(RTC_VERSION_MAJOR) +
                             ", but the process has Embree " + std::to_string(major) + " loaded");
  if (!ray_finds_triangle(device.get()))
    throw std::runtime_error(
        "Embree does not find a test ray's hit: another copy of it seems to be in this process");
}

}  // namespace penumbra::embree
