// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as a scene and settings, built and rendered: it is refused with an exception, or every pixel is
// finite.
#include <cstdio>
#include <cstdlib>

#include "bytes.h"
#include "render/renderer.h"

namespace penumbra {
namespace {

using fuzz::Bytes;

Mesh read_mesh(Bytes& in) {
  Mesh mesh;
  mesh.name = "mesh";
  const uint32_t vertices = 3 + in.below(24), triangles = in.below(32);
  for (uint32_t i = 0; i < vertices; ++i) mesh.positions.push_back(in.vector());
  for (uint32_t i = 0; i < triangles; ++i) {
    // Mostly in range; one byte beyond now and then.
    const auto index = [&] { return in.byte() < 254 ? in.byte() % vertices : in.bits<uint32_t>(); };
    const uint32_t a = index(), b = index(), c = index();
    mesh.triangles.push_back({a, b, c});
  }
  if (in.below(3) == 0)
    for (uint32_t i = 0; i < 3 * triangles; ++i) mesh.corner_normals.push_back(Vec3f(in.vector()));
  if (in.below(3) == 0)
    for (uint32_t i = 0; i < triangles; ++i) mesh.material_slots.push_back(in.below(4));
  return mesh;
}

void read_luminaire(Bytes& in, Scene& scene) {
  const Affine place = in.transform();
  const double x = in.number(), y = in.number();
  const Vec3d radiance = in.vector();
  if (in.flag()) {
    const auto shape = in.flag() ? LuminaireShape::kRectangle : LuminaireShape::kEllipse;
    scene.add_luminaire(
        AreaLuminaire{"area", shape, place, std::abs(x), std::abs(y), radiance, in.byte() > 20});
    return;
  }
  PointLuminaire point{"point",  in.flag() ? RoundShape::kSphere : RoundShape::kFacingDisk,
                       place,    std::abs(x),
                       radiance, in.byte() > 20,
                       {}};
  if (in.flag()) point.spot = SpotCone{std::abs(y), in.share(), in.flag()};
  scene.add_luminaire(point);
}

void read_camera(Bytes& in, Scene& scene) {
  Camera camera;
  camera.kind = in.flag() ? CameraKind::kPerspective : CameraKind::kOrthographic;
  camera.world_from_camera.origin = {0, 0, 4};
  if (in.below(4) == 0) camera.world_from_camera = in.transform();
  if (in.below(8) == 0) camera.left = in.number(), camera.top = in.number();
  camera.clip_start = in.share(), camera.clip_end = 100 + in.number();
  scene.set_camera(camera);
}

RenderSettings read_settings(Bytes& in) {
  RenderSettings s;
  s.width = 1 + in.below(20), s.height = 1 + in.below(20);
  if (in.below(4) == 0) s.region = {in.below(9), in.below(9), in.below(9), in.below(9)};
  s.stop_rule = StopRuleKind(in.below(4));
  if (s.stop_rule != StopRuleKind::kBounded || in.byte() < 8) {
    s.sampler = SamplerKind(in.below(5));
    s.sample_reuse = SampleReuse(in.below(4));
  }
  s.light_samples = 1 + in.below(40), s.max_light_samples = 16 + in.below(48);
  s.check_interval = 1 + in.below(20);
  s.pixel_samples = 1 + in.below(5), s.max_pixel_samples = 16 + in.below(48);
  s.filter_type = FilterKind(in.below(2));
  s.filter_width = 4 * in.share();
  s.mirror_depth = in.below(6);
  s.seed = in.bits<uint32_t>();
  s.error_tolerance = 1e-3 + in.share();
  if (in.below(4) == 0) s.exposure = in.number();
  s.threads = 1;
  s.passes = {"Combined", "Depth", "Normal", "Position", "Light Samples"};
  return s;
}

void check(const Film& film, const RenderSettings& settings) {
  const auto fail = [](const std::string& why) {
    std::fprintf(stderr, "fuzz_scene: %s\n", why.c_str());
    std::abort();
  };
  for (const std::string& name : settings.passes)
    for (float value : film.pass(name))
      if (!std::isfinite(value)) fail("a value of " + name + " is not finite");
  const std::vector<float>& combined = film.pass("Combined");
  for (size_t i = 3; i < combined.size(); i += 4)
    if (!(combined[i] >= -1e-6f && combined[i] <= 1 + 1e-6f)) fail("alpha is not in 0 ... 1");
}

void render(Bytes& in) {
  auto scene = std::make_shared<Scene>();
  read_camera(in, *scene);
  scene->set_background({in.colour(), in.flag()});
  const uint32_t materials = 1 + in.below(3), meshes = 1 + in.below(3), instances = in.below(6),
                 lights = in.below(4);
  for (uint32_t i = 0; i < materials; ++i) {
    Material material;
    material.name = "material";
    material.diffuse = in.colour();
    if (in.flag()) material.phong = in.colour() * 0.3, material.phong_exponent = std::abs(in.number()) * 10;
    if (in.flag()) material.mirror = in.colour() * 0.3;
    if (in.byte() < 250) material.diffuse = material.diffuse * 0.4;
    scene->add_material(material);
  }
  for (uint32_t i = 0; i < meshes; ++i) scene->add_mesh(read_mesh(in));
  for (uint32_t i = 0; i < instances; ++i)
    scene->add_instance({"instance",
                         in.byte() < 250 ? in.below(meshes) : in.below(9),
                         in.transform(),
                         {in.below(materials), in.byte() < 250 ? in.below(materials) : in.below(9)}});
  for (uint32_t i = 0; i < lights; ++i) read_luminaire(in, *scene);
  const RenderSettings settings = read_settings(in);
  auto [mesh_list, instance_list] = scene->release_geometry();
  const auto geometry = std::make_shared<Geometry>(std::move(mesh_list), std::move(instance_list));
  Renderer renderer(scene, geometry, std::make_shared<const Materials>(scene), settings);
  renderer.start();
  renderer.finish();
  check(renderer.film(), renderer.settings());
}

}  // namespace
}  // namespace penumbra

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  penumbra::fuzz::Bytes in(data, size);
  try {
    penumbra::render(in);
  } catch (const std::invalid_argument&) {  // a refusal: what should happen to nonsense
  }
  return 0;
}
