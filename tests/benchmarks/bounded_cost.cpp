// SPDX-License-Identifier: GPL-3.0-or-later
// What BOUNDED costs a pixel, by scene and tolerance, one thread: bounded_cost [WIDTH] [ROUNDS] [SCENE...].
// CPU microseconds of the whole render (least of all rounds) and rays, by one centre ray and antialiased.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "math/simd.h"
#include "render/renderer.h"
#include "scenes.h"

namespace penumbra::benchmark {
namespace {

void measure(const NamedScene& named, uint32_t width, int rounds) {
  auto scene = std::make_shared<Scene>(named.make());
  auto [meshes, instances] = scene->release_geometry();
  const auto geometry = std::make_shared<Geometry>(std::move(meshes), std::move(instances));
  for (const uint32_t pixel_samples : {1u, 16u}) {
    for (const double tolerance : {0.1, 0.02, 0.004}) {
      RenderSettings settings;
      settings.width = width;
      settings.height = width * 3 / 4;
      settings.error_tolerance = tolerance;
      settings.pixel_samples = pixel_samples;
      settings.threads = 1;
      settings = settings.validated();
      double seconds = 1e30;
      RenderTally tally;
      for (int i = 0; i < rounds; ++i) {
        const double begin = cpu_seconds();
        Renderer renderer(scene, geometry, std::make_shared<Materials>(scene), settings);
        renderer.start();
        renderer.finish();
        seconds = std::min(seconds, cpu_seconds() - begin);
        tally = renderer.statistics().tally;
      }
      const double pixels = double(settings.width) * settings.height;
      std::printf("%-24s %-11s %5.3f: %8.3f us, %8.2f primary, %8.2f shadow rays a pixel\n",
                  named.name.c_str(), pixel_samples > 1 ? "antialiased" : "centre ray", tolerance,
                  1e6 * seconds / pixels, double(tally.primary_rays) / pixels,
                  double(tally.light.shadow_rays) / pixels);
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace penumbra::benchmark

int main(int argc, char** argv) {
  using namespace penumbra::benchmark;
  const int width = argc > 1 ? std::atoi(argv[1]) : 320, rounds = argc > 2 ? std::atoi(argv[2]) : 3;
  if (width < 8 || rounds < 1) {
    std::fprintf(stderr, "bounded_cost [WIDTH >= 8] [ROUNDS >= 1] [SCENE...]\n");
    return 2;
  }
  penumbra::flush_denormals();
  for (const NamedScene& scene : scenes())
    if (argc < 4 || std::any_of(argv + 3, argv + argc, [&](const char* a) { return scene.name == a; }))
      measure(scene, uint32_t(width), rounds);
}
