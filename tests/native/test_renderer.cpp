// SPDX-License-Identifier: GPL-3.0-or-later
// Renders as threads see them: started, cancelled, dropped, two at a time. Run these with the preset `tsan`,
// too.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <random>
#include <thread>

#include "render/renderer.h"
#include "small_scene.h"

namespace penumbra {
namespace {

/// A plate over a floor, under a square luminaire, seen from above.
std::shared_ptr<const Scene> make_scene(std::shared_ptr<const Geometry>& geometry) {
  auto scene = std::make_shared<Scene>();
  Material grey;
  grey.name = "grey";
  grey.diffuse = {0.5, 0.5, 0.5};
  const uint32_t material = scene->add_material(grey);
  scene->add_mesh(test::quad({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}));
  scene->add_mesh(test::quad({-0.5, -0.5, 1}, {1, 0, 0}, {0, 1, 0}));
  for (uint32_t mesh : {0u, 1u}) scene->add_instance({"object", mesh, {}, {material}});
  Affine above;
  above.origin = {0, 0, 2};
  scene->add_luminaire({"key", LuminaireShape::kRectangle, above, 1, 1, {3, 3, 3}});
  Camera camera;
  camera.kind = CameraKind::kOrthographic;
  camera.world_from_camera.origin = {0, 0, 10};
  camera.window = {-2, 2, -2, 2};
  scene->set_camera(camera);
  auto [meshes, instances] = scene->release_geometry();
  geometry = std::make_shared<Geometry>(std::move(meshes), std::move(instances));
  return scene;
}

class Renders : public ::testing::TestWithParam<bool> {
 protected:
  Renders() : scene_(make_scene(geometry_)) {
    settings_.width = 72;  // two buckets wide
    settings_.height = 24;
    settings_.threads = 3;
    settings_.error_tolerance = 0.1;
    if (GetParam()) settings_.pixel_samples = 2;  // antialiased
  }

  std::unique_ptr<Renderer> make() const {
    return std::make_unique<Renderer>(scene_, geometry_, std::make_shared<const Materials>(scene_),
                                      settings_);
  }

  /// Combined of a whole render.
  std::vector<float> picture() const {
    const auto render = make();
    render->start();
    render->finish();
    const std::span<const float> values = render->film().pass("Combined");
    return {values.begin(), values.end()};
  }

  std::shared_ptr<const Geometry> geometry_;
  std::shared_ptr<const Scene> scene_;
  RenderSettings settings_;
};

INSTANTIATE_TEST_SUITE_P(CentreRayAndAntialiased, Renders, ::testing::Bool());

TEST_P(Renders, AreNotDoneBeforeTheyStart) {
  const auto render = make();
  EXPECT_FALSE(render->done());
  EXPECT_TRUE(render->wait(0).empty());
  render->start();
  size_t buckets = 0;
  while (!render->done()) buckets += render->wait(1).size();
  EXPECT_EQ(buckets, 2u);
  EXPECT_EQ(render->progress(), 1.0);
  render->finish();
  EXPECT_EQ(render->statistics().tally.non_finite_pixels, 0u);
}

/// A thousand renders by both, cancelled within the time that one takes or dropped while they run; the next
/// one is right.
TEST_P(Renders, CancelledAtRandomMoments) {
  const std::vector<float> expected = picture();
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(picture(), expected);
  const double whole = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> moment(0, std::min(whole, 4e-3));
  const int times = GetParam() ? 200 : 800;
  for (int i = 0; i < times; ++i) {
    const auto render = make();
    render->start();
    std::this_thread::sleep_for(std::chrono::duration<double>(moment(random)));
    if (i % 3 == 0) continue;  // dropped
    render->cancel();
    if (i % 3 == 1) render->wait(0);
    render->finish();
    while (!render->done()) render->wait(1);
    for (float value : render->film().pass("Combined")) ASSERT_TRUE(std::isfinite(value));
  }
  EXPECT_EQ(picture(), expected);
}

TEST_P(Renders, TwoAtATimeAreTheSame) {
  const std::vector<float> expected = picture();
  std::vector<float> pictures[2];
  std::thread other([&] { pictures[0] = picture(); });
  pictures[1] = picture();
  other.join();
  EXPECT_EQ(pictures[0], expected);
  EXPECT_EQ(pictures[1], expected);
}

/// Whoever watches a render may ask at any time.
TEST_P(Renders, AreWatchedByAnotherThread) {
  const auto render = make();
  std::thread watcher([&] {
    while (!render->done()) {
      render->wait(1e-3);
      EXPECT_LE(render->progress(), 1.0);
    }
  });
  render->start();
  render->start();
  watcher.join();
  render->finish();
  EXPECT_EQ(render->statistics().tally.primary_rays > 0, true);
}

TEST_P(Renders, MemoryLimitIsAnErrorThatSaysSo) {
  settings_.memory_limit = 1;
  settings_.width = settings_.height = 512;
  try {
    make();
    FAIL() << "512 x 512 pixels of Combined and Error Estimate are 5 MiB";
  } catch (const std::bad_alloc& error) {
    EXPECT_NE(std::string(error.what()).find("memory_limit of 1 MiB"), std::string::npos) << error.what();
  }
}

/// Against the sorted values: at most 1/32 above, never below.
TEST(ErrorHistogram, TellsQuantiles) {
  std::mt19937 random(7);
  std::lognormal_distribution<float> errors(-6, 3);
  ErrorHistogram histogram;
  EXPECT_EQ(histogram.quantile(0.99), 0);
  std::vector<float> values(100, 0.0f);
  for (int i = 0; i < 10000; ++i) values.push_back(errors(random));
  values.push_back(std::numeric_limits<float>::max());
  for (float value : values) histogram.add(value);
  std::sort(values.begin(), values.end());
  for (double share : {0.0, 0.005, 0.5, 0.99, 1.0}) {
    const double exact = values[size_t(double(values.size() - 1) * share)], told = histogram.quantile(share);
    EXPECT_GE(told, exact);
    EXPECT_LE(told, exact * (1 + 1.0 / 32));
    EXPECT_EQ(histogram.exact_quantile(share, values), exact);
  }
}

TEST(GeometryMemory, LimitIsAnErrorAndTheNextBuildIsFine) {
  const auto build = [](uint64_t limit) {
    Mesh strip;
    strip.name = "strip";
    for (int i = 0; i < 20002; ++i) strip.positions.push_back({double(i / 2), double(i % 2), 0});
    for (uint32_t i = 0; i < 20000; ++i) strip.triangles.push_back({i, i + 1, i + 2});
    std::vector<Mesh> meshes;
    meshes.push_back(std::move(strip));
    return std::make_unique<Geometry>(std::move(meshes), std::vector<Instance>{{"strip", 0, {}, {0}}}, limit);
  };
  EXPECT_EQ(build(0)->triangles(), 20000u);
  EXPECT_THROW(build(1 << 18), MemoryLimitReached);
  EXPECT_EQ(build(1 << 28)->triangles(), 20000u);
}

}  // namespace
}  // namespace penumbra
