// SPDX-License-Identifier: GPL-3.0-or-later
// Shadow rays per second of a whole render with FIXED 64 points, against a raw Embree loop over the same
// rays (the faster of both of Embree's traversals), one thread, alternating in one run: ray_rate [WIDTH]
// [ROUNDS]. Prints a table; CSV on request
// (--csv).
#include <bit>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "math/simd.h"
#include "render/renderer.h"
#include "sampling/hash.h"
#include "scenes.h"

namespace penumbra::benchmark {
namespace {

constexpr uint32_t kPoints = 64;

/// The rays of one pixel, as the render traces them.
struct PixelRays {
  Vec3f origin;
  float x[kPoints], y[kPoints], z[kPoints];
  uint16_t active[kPoints / kPacket];
};

RenderSettings settings_of(uint32_t width) {
  RenderSettings s;
  s.width = width;
  s.height = width * 3 / 4;
  s.stop_rule = StopRuleKind::kFixed;
  s.light_samples = kPoints;
  s.threads = 1;
  return s.validated();
}

/// All shadow rays, in the order of the tiles.
std::vector<PixelRays> collect_rays(const Scene& scene, const Geometry& geometry, const RenderSettings& s) {
  const CameraRays camera(scene.camera(), geometry.normalization(), s.width, s.height);
  const Luminaire light(scene.luminaires()[0], geometry.normalization());
  const auto sampler = make_sampler(s.sampler_settings());
  std::vector<PixelRays> all;
  for (uint32_t ty = 0; ty < s.height; ty += kTile) {
    for (uint32_t tx = 0; tx < s.width; tx += kTile) {
      for (uint32_t i = 0; i < kTile * kTile; ++i) {
        const uint32_t x = tx + i % kTile, y = ty + i / kTile;
        const Ray ray = camera.through(x + 0.5, y + 0.5);
        Hit hit;
        geometry.intersect(&ray, 1, &hit);
        if (!hit.found()) continue;
        PlacedPoint surface;
        geometry.surface_point(ray, hit, surface);
        if (light.unseen_from(surface)) continue;
        alignas(64) float u[kPoints], v[kPoints];
        LightPoints points;
        const uint64_t stream = uint64_t(y) * s.width + x;
        sampler->points({stream, hash_of(stream)}, 0, kPoints, u, v);
        light.evaluate(surface, u, v, kPoints, points);
        PixelRays rays;
        rays.origin = Vec3f(surface.position + surface.geometric_normal * surface.rounding);
        std::memcpy(rays.x, points.x, sizeof(rays.x));
        std::memcpy(rays.y, points.y, sizeof(rays.y));
        std::memcpy(rays.z, points.z, sizeof(rays.z));
        for (uint32_t p = 0; p < kPoints / kPacket; ++p) {
          rays.active[p] = 0;
          for (uint32_t k = 0; k < kPacket; ++k)
            rays.active[p] |= uint16_t((points.form_factor[p * kPacket + k] > 0) << k);
        }
        all.push_back(rays);
      }
    }
  }
  return all;
}

struct Count {
  uint64_t rays = 0, occluded = 0;
};

Count trace_raw(RTCScene scene, bool coherent, const std::vector<PixelRays>& all) {
  Count count;
  alignas(64) RTCRay16 packet{};
  alignas(64) int valid[kPacket];
  for (uint32_t k = 0; k < kPacket; ++k) packet.mask[k] = ~0u;
  for (const PixelRays& rays : all) {
    for (uint32_t p = 0; p < kPoints / kPacket; ++p) {
      const uint32_t active = rays.active[p];
      if (!active) continue;
      for (uint32_t k = 0; k < kPacket; ++k) {
        valid[k] = -int(active >> k & 1);
        packet.org_x[k] = rays.origin.x, packet.org_y[k] = rays.origin.y, packet.org_z[k] = rays.origin.z;
        packet.tnear[k] = 0, packet.tfar[k] = 1;
      }
      std::memcpy(packet.dir_x, rays.x + p * kPacket, sizeof(packet.dir_x));
      std::memcpy(packet.dir_y, rays.y + p * kPacket, sizeof(packet.dir_y));
      std::memcpy(packet.dir_z, rays.z + p * kPacket, sizeof(packet.dir_z));
      embree::occluded16(valid, scene, packet, nullptr, nullptr, nullptr, coherent);
      uint32_t hit = 0;
      for (uint32_t k = 0; k < kPacket; ++k) hit |= uint32_t(packet.tfar[k] < 0) << k;
      count.rays += std::popcount(active);
      count.occluded += std::popcount(hit & active);
    }
  }
  return count;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void measure(const NamedScene& named, uint32_t width, int rounds, bool csv) {
  auto scene = std::make_shared<Scene>(named.make());
  auto [meshes, instances] = scene->release_geometry();
  const auto geometry = std::make_shared<Geometry>(std::move(meshes), std::move(instances));
  const RenderSettings settings = settings_of(width);
  const std::vector<PixelRays> rays = collect_rays(*scene, *geometry, settings);

  std::vector<double> raw, whole, ratio;
  uint64_t raw_rays = 0, whole_rays = 0;
  for (int i = 0; i < rounds; ++i) {
    double best = 0;
    for (bool coherent : {false, true}) {
      if (coherent && geometry->has_shared_meshes()) continue;
      const double begin = cpu_seconds();
      raw_rays = trace_raw(geometry->embree_scene(), coherent, rays).rays;
      best = std::max(best, double(raw_rays) / (cpu_seconds() - begin) / 1e6);
    }
    raw.push_back(best);

    const double begin = cpu_seconds();
    Renderer renderer(scene, geometry, std::make_shared<Materials>(scene), settings);
    renderer.start();
    renderer.finish();
    whole_rays = renderer.statistics().tally.light.shadow_rays;
    whole.push_back(double(whole_rays) / (cpu_seconds() - begin) / 1e6);
    ratio.push_back(whole.back() / raw.back());
  }
  if (raw_rays != whole_rays)
    std::fprintf(stderr, "note: raw loop %llu rays, render %llu\n", static_cast<unsigned long long>(raw_rays),
                 static_cast<unsigned long long>(whole_rays));
  std::printf(csv ? "%s;%llu;%llu;%.3f;%.3f;%.4f\n"
                  : "%-24s %9llu triangles %10llu rays  raw %6.1f M/s  render %6.1f M/s  ratio %.3f\n",
              named.name.c_str(), static_cast<unsigned long long>(geometry->triangles()),
              static_cast<unsigned long long>(whole_rays), median(raw), median(whole), median(ratio));
  std::fflush(stdout);
}

}  // namespace
}  // namespace penumbra::benchmark

int main(int argc, char** argv) {
  using namespace penumbra::benchmark;
  const bool csv = argc > 1 && !std::strcmp(argv[argc - 1], "--csv");
  if (csv) --argc;
  const int width = argc > 1 ? std::atoi(argv[1]) : 320, rounds = argc > 2 ? std::atoi(argv[2]) : 5;
  if (width < 8 || rounds < 1) {
    std::fprintf(stderr, "ray_rate [WIDTH >= 8] [ROUNDS >= 1] [--csv]\n");
    return 2;
  }
  penumbra::flush_denormals();
  if (csv) std::printf("scene;triangles;shadow_rays;raw_mrays_s;render_mrays_s;ratio\n");
  for (const NamedScene& scene : scenes()) measure(scene, uint32_t(width), rounds, csv);
}
