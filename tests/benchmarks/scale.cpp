// SPDX-License-Identifier: GPL-3.0-or-later
// What grows with triangles, pixels and threads: scale [triangles] [pixels] [threads], all if left out; CSV
// with --csv at the end. Each row is measured in a process of its own, so that memory is its own.
//
// triangles: a bumpy floor of 10^3 ... 10^7 under a rectangle, 640 x 480, BOUNDED 0.004, one thread. Build:
// CPU time from the scene to what rays are traced against, and of an Embree scene of the same arrays and
// flags alone: the least of a few that take turns, since memory that a process, or a virtual machine, touches
// for the first time costs both as much as a fifth more. Memory: resident, above what the process had before
// the scene's arrays; those of Blender are not in it. Peak: the most while making, building and rendering.
// Smooth: with normals at each corner. pixels: four objects at 0.1 ... 16 Mpixel. threads: the same at 4
// Mpixel, elapsed, with the machine's load.
#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>

#include "math/simd.h"
#include "render/renderer.h"
#include "scenes.h"

namespace penumbra::benchmark {
namespace {

bool csv = false;
constexpr int kTurns = 3;

/// Bytes, of a line of /proc/self/status.
double status(const std::string& name) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(name + ":")) return 1024 * std::strtod(line.c_str() + name.size() + 1, nullptr);
  return 0;
}

double resident() {
  malloc_trim(0);
  return status("VmRSS");
}

double elapsed_seconds() {
  using namespace std::chrono;
  return duration<double>(steady_clock::now().time_since_epoch()).count();
}

double load() {
  double average = 0;
  std::ifstream("/proc/loadavg") >> average;
  return average;
}

struct Rendered {
  double cpu = 0, elapsed = 0;
};

Rendered render(std::shared_ptr<const Scene> scene, std::shared_ptr<const Geometry> geometry, uint32_t width,
                uint32_t height, uint32_t threads) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.error_tolerance = 0.004;
  settings.pixel_samples = 1;
  settings.threads = threads;
  const double cpu = cpu_seconds(), start = elapsed_seconds();
  Renderer renderer(scene, geometry, std::make_shared<Materials>(scene), settings.validated());
  renderer.start();
  renderer.finish();
  return {cpu_seconds() - cpu, elapsed_seconds() - start};
}

/// CPU seconds of Embree alone over a copy of the mesh in single precision.
double embree_build(const Mesh& mesh) {
  std::vector<Vec3f> positions(mesh.positions.begin(), mesh.positions.end());
  positions.emplace_back();
  RTCDevice device = rtcNewDevice(nullptr);
  const double start = cpu_seconds();
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions.data(), 0,
                             sizeof(Vec3f), positions.size() - 1);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                             3 * sizeof(uint32_t), mesh.triangles.size());
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  const double seconds = cpu_seconds() - start;
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  return seconds;
}

struct Built {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Geometry> geometry;
  double cpu = 0;
};

Built build(uint32_t triangles, bool smooth) {
  auto scene = std::make_shared<Scene>(under_a_rectangle(bumpy_floor(triangles, smooth)));
  const double start = cpu_seconds();
  auto [meshes, instances] = scene->release_geometry();
  auto geometry = std::make_shared<Geometry>(std::move(meshes), std::move(instances));
  return {scene, geometry, cpu_seconds() - start};
}

void measure_triangles(uint32_t triangles, bool smooth) {
  embree_build(bumpy_floor(100, false));  // what loading Embree takes is not the scene's
  const double before = resident();
  Built built = build(triangles, smooth);
  const double kept = resident() - before, peak = status("VmHWM") - before;
  const double count = double(built.geometry->triangles());
  const double seconds = render(built.scene, built.geometry, 640, 480, 1).cpu, most = status("VmHWM");
  double ours = built.cpu, alone = 1e9;
  built = {};
  const Mesh mesh = bumpy_floor(triangles, false);
  for (int turn = 0; turn < kTurns; ++turn) {
    alone = std::min(alone, embree_build(mesh));
    ours = std::min(ours, build(triangles, smooth).cpu);
  }
  std::printf(
      csv ? "triangles;%.0f;%s;%.4f;%.4f;%.3f;%.1f;%.1f;%.0f;%.4f\n"
          : "%9.0f triangles, %-6s  build %7.3f s, Embree %7.3f s, ratio %5.2f  %6.1f bytes a triangle, "
            "%6.1f at the peak, %5.0f MB in all  %7.3f us a pixel\n",
      count, smooth ? "smooth" : "flat", ours, alone, ours / alone, kept / count, peak / count, most / 1e6,
      1e6 * seconds / (640 * 480));
}

void measure_pixels(uint32_t width, uint32_t height, uint32_t threads) {
  const auto named = std::find_if(scenes().begin(), scenes().end(),
                                  [](const NamedScene& s) { return s.name == "four objects"; });
  auto scene = std::make_shared<Scene>(named->make());
  auto [meshes, instances] = scene->release_geometry();
  auto geometry = std::make_shared<Geometry>(std::move(meshes), std::move(instances));
  const double pixels = double(width) * height, before = resident();
  const Rendered done = render(scene, geometry, width, height, threads);
  std::printf(csv ? "pixels;%.0f;%u;%.4f;%.4f;%.1f;%.2f\n"
                  : "%9.0f pixels, %u threads  CPU %7.3f us, elapsed %7.3f us a pixel  %5.1f bytes a pixel  "
                    "load %.2f\n",
              pixels, threads, 1e6 * done.cpu / pixels, 1e6 * done.elapsed / pixels,
              (status("VmHWM") - before) / pixels, load());
}

/// In a process of its own. Whether it ended well.
bool apart(const std::function<void()>& work) {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    flush_denormals();
    work();
    std::fflush(stdout);
    _exit(0);
  }
  int state = 0;
  return child > 0 && waitpid(child, &state, 0) == child && state == 0;
}

}  // namespace
}  // namespace penumbra::benchmark

int main(int argc, char** argv) {
  using namespace penumbra::benchmark;
  csv = argc > 1 && !std::strcmp(argv[argc - 1], "--csv");
  if (csv) --argc;
  const auto wanted = [&](const char* what) {
    return argc < 2 ||
           std::any_of(argv + 1, argv + argc, [&](const char* a) { return !std::strcmp(a, what); });
  };
  bool well = true;
  if (wanted("triangles")) {
    if (csv)
      std::puts(
          "what;triangles;normals;build_s;embree_s;ratio;bytes_a_triangle;peak_bytes_a_triangle;peak_mb;us_a_"
          "pixel");
    for (uint32_t n = 1000; n <= 10'000'000; n *= 10) well &= apart([n] { measure_triangles(n, false); });
    well &= apart([] { measure_triangles(1'000'000, true); });
  }
  if (csv && (wanted("pixels") || wanted("threads")))
    std::puts("what;pixels;threads;cpu_us_a_pixel;elapsed_us_a_pixel;bytes_a_pixel;load");
  if (wanted("pixels"))
    for (uint32_t side : {91u, 289u, 577u, 1155u})
      well &= apart([side] { measure_pixels(4 * side, 3 * side, 1); });
  if (wanted("threads"))
    for (int round = 0; round < 3; ++round)
      for (uint32_t threads : {1u, 2u}) well &= apart([threads] { measure_pixels(2308, 1731, threads); });
  return well ? 0 : 1;
}
