// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as a scene and settings, built and rendered: it is refused with an exception, or every pixel is
// finite, and the same in two renders at once.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <optional>

#include "bytes.h"
#include "material/evaluate.h"
#include "render/renderer.h"
#include "scene/strands.h"

namespace penumbra {
namespace {

using fuzz::Bytes;

/// Mostly at two or three times, of which each vertex has its own place.
uint32_t read_times(Bytes& in) {
  return in.below(5) < 4 ? 0 : in.byte() < 250 ? 2 + in.below(2) : in.byte();
}

void read_motion(Bytes& in, Mesh& mesh) {
  for (uint32_t time = read_times(in); time > 0; --time) {
    MeshPose pose{mesh.positions, mesh.corner_normals};
    for (Vec3d& p : pose.positions) p += in.vector() * 0.2;
    if (in.byte() > 250) pose.positions.resize(mesh.positions.size() / 2);
    mesh.motion.push_back(std::move(pose));
  }
}

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
  read_motion(in, mesh);
  return mesh;
}

/// Curves or spheres, of keys some of which are no use.
Mesh read_strands(Bytes& in) {
  Mesh mesh;
  mesh.name = "hair";
  std::vector<uint32_t> counts;
  for (uint32_t curve = in.below(6); curve > 0; --curve) {
    counts.push_back(in.byte() < 250 ? in.below(7) : in.byte());
    for (uint32_t i = std::min(counts.back(), 6u); i > 0; --i) {
      mesh.positions.push_back(in.vector());
      mesh.radii.push_back(float(in.byte() < 250 ? 0.3 * in.share() : in.number()));
    }
  }
  read_motion(in, mesh);
  mesh.strands = StrandShape(1 + in.below(3));
  mesh.strands == StrandShape::kSphere ? make_points(mesh) : make_curves(mesh, counts);
  return mesh;
}

/// Of every kind.
void read_luminaire(Bytes& in, Scene& scene) {
  const Affine place = in.transform();
  const double x = in.number(), y = in.number();
  const Vec3d radiance = in.vector();
  const bool shadow = in.byte() > 20;
  LuminaireRole role;
  if (in.flag())
    role = {in.flag(), in.flag(), in.flag(), in.flag(), in.flag() ? kShadowRay : in.bits<RayMask>(), {}};
  for (uint32_t i = in.below(4); i > 0; --i) role.receivers.push_back(in.flag());
  switch (in.below(5)) {
    case 0:
    case 1: {
      const auto shape = in.flag() ? LuminaireShape::kRectangle : LuminaireShape::kEllipse;
      AreaLuminaire area{"area",           shape, place, std::abs(x), std::abs(y), radiance, shadow,
                         std::numbers::pi, role};
      if (in.below(3) == 0) area.spread = std::numbers::pi * in.share();
      return scene.add_luminaire(area);
    }
    case 2: {
      PointLuminaire point{"point",  in.flag() ? RoundShape::kSphere : RoundShape::kFacingDisk,
                           place,    std::abs(x),
                           radiance, shadow,
                           {},       role};
      if (in.flag()) point.spot = SpotCone{std::abs(y), in.share(), in.flag()};
      return scene.add_luminaire(point);
    }
    case 3:
      return scene.add_luminaire(SunLuminaire{"sun", place.z_axis, 1.6 * in.share(), radiance, shadow, role});
    default: {
      Mesh mesh = read_mesh(in);
      for (Vec3d& p : mesh.positions) p = place.point(p);
      return scene.add_luminaire(MeshLuminaire{"glowing", std::move(mesh.positions),
                                               std::move(mesh.triangles), radiance, shadow, role});
    }
  }
}

Background read_background(Bytes& in) {
  Background background{in.colour(), in.flag()};
  background.lights = in.flag(), background.seen_by_camera = in.flag();
  if (in.flag()) return background;
  auto sky = std::make_shared<Environment>();
  const uint32_t width = 1 + in.below(8), height = 1 + in.below(8);
  std::vector<Vec3f> pixels;
  for (uint32_t i = 0; i < width * height; ++i)
    pixels.push_back(in.byte() < 250 ? Vec3f(in.colour()) : Vec3f(in.vector()));
  sky->picture = std::make_shared<const SkyPicture>(width, height, std::move(pixels));
  sky->local_from_world = in.below(4) == 0 ? in.transform() : Affine{};
  sky->smooth = in.flag();
  background.environment = sky;
  return background;
}

/// Operations of all names on each other's results, and closures of them.
Material read_program(Bytes& in, size_t images) {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = operation_names();
    std::sort(all.begin(), all.end());
    return all;
  }();
  Program program;
  const uint32_t constants = 1 + in.below(8), steps = in.below(12);
  program.registers.emplace_back();
  for (uint32_t i = 1; i < constants; ++i)
    program.registers.push_back(in.flag() ? Vec3f(in.colour()) : Vec3f(in.vector()));
  for (uint32_t i = in.below(40); i > 0; --i) program.tables.push_back(float(in.number()));
  if (in.flag()) program.tables = {2, 0, 0, 0, 0, 1, 1, 1, 1, 1, 0, 0};  // a ramp, a matrix
  for (uint32_t i = 0; i < steps; ++i) {
    const NamedOperation* named = find_operation(names[in.byte() * 256u % names.size()]);
    if (in.flag()) named = find_operation(names[in.byte() % names.size()]);
    const int32_t data = in.byte() < 200 ? 0 : in.byte();
    if (!named->fits(data, program.tables, images)) continue;
    Operation operation{named->function, {}, uint16_t(program.registers.size()), uint16_t(in.below(3)), data};
    for (uint16_t& input : operation.in) input = uint16_t(in.byte() % program.registers.size());
    program.operations.push_back(operation);
    program.registers.resize(program.registers.size() + 2);
  }
  const auto any_register = [&] {
    return uint16_t(program.registers.size() - 1 - in.byte() % program.registers.size());
  };
  for (uint32_t i = in.below(4); i > 0; --i) {
    const auto kind = ClosureKind(in.below(uint32_t(ClosureKind::kHoldout) + 1));
    const uint16_t colour = any_register(), edge = any_register(), ior = any_register();
    program.closures.push_back({kind, colour, edge, ior, any_register()});
  }
  if (in.below(3) == 0) program.normal = any_register();
  fold(program);
  Material material;
  if (is_constant(program)) {
    static_cast<Closures&>(material) = constant_closures(program);
  } else {
    if (program.has(ClosureKind::kTransparent))
      material.shadow_program = std::make_shared<const Program>(part_of(program, ClosureKind::kTransparent));
    material.program = std::make_shared<const Program>(std::move(program));
  }
  material.name = "program";
  return material;
}

/// A file of 4 x 2 pixels, or of any bytes.
Image read_image(Bytes& in) {
  Image image;
  image.name = "image";
  std::string bytes;
  if (in.byte() < 230) {
    float pixels[4 * 2 * 4];
    const uint32_t channels = 1 + in.below(4);
    for (float& pixel : pixels) pixel = float(in.byte() < 250 ? in.share() : in.number());
    bytes = encode_image(4, 2, channels, pixels);
  } else {
    for (uint32_t i = in.byte(); i > 0; --i) bytes.push_back(char(in.byte()));
  }
  image.files.push_back({1001 + in.byte() / 250u, "pixels.exr", std::make_shared<const std::string>(bytes)});
  image.tiled = in.below(4) == 0, image.srgb = in.flag();
  image.wrap = ImageWrap(in.below(4));
  image.interpolation = ImageInterpolation(in.below(3));
  image.alpha = ImageAlpha(in.below(4));
  return image;
}

/// The paper's BRDF.
Material read_material(Bytes& in) {
  Material material;
  material.name = "material";
  material.diffuse = in.colour();
  if (in.flag()) material.phong = in.colour() * 0.3, material.phong_exponent = std::abs(in.number()) * 10;
  if (in.flag()) material.mirror = in.colour() * 0.3;
  if (in.byte() < 250) material.diffuse = material.diffuse * 0.4;
  return material;
}

void read_camera(Bytes& in, Scene& scene) {
  Camera camera;
  camera.kind = in.flag() ? CameraKind::kPerspective : CameraKind::kOrthographic;
  camera.world_from_camera.origin = {0, 0, 4};
  if (in.below(4) == 0) camera.world_from_camera = in.transform();
  if (in.below(8) == 0) camera.window.left = in.number(), camera.window.top = in.number();
  camera.clip_start = in.share(), camera.clip_end = 100 + in.number();
  for (uint32_t time = read_times(in); time > 0; --time) {
    camera.motion.push_back(in.transform());
    camera.window_motion.push_back(camera.window);
  }
  if (in.below(4) == 3) camera.aperture = {in.share(), in.number(), in.below(8), in.number(), in.share()};
  for (uint32_t i = in.below(4); i > 0; --i) camera.shutter.push_back(in.number());
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

[[noreturn]] void fail(const std::string& why) {
  std::fprintf(stderr, "fuzz_scene: %s\n", why.c_str());
  std::abort();
}

void check(const Film& film, const RenderSettings& settings) {
  for (const std::string& name : settings.passes)
    for (float value : film.pass(name))
      if (!std::isfinite(value)) fail("a value of " + name + " is not finite");
  const std::span<const float> combined = film.pass("Combined");
  for (size_t i = 3; i < combined.size(); i += 4)
    if (!(combined[i] >= -1e-6f && combined[i] <= 1 + 1e-6f)) fail("alpha is not in 0 ... 1");
}

void render(Bytes& in) {
  auto scene = std::make_shared<Scene>();
  read_camera(in, *scene);
  scene->set_background(read_background(in));
  const uint32_t images = in.below(8) == 7, materials = 1 + in.below(3), meshes = 1 + in.below(3),
                 instances = in.below(6), lights = in.below(4);
  for (uint32_t i = 0; i < images; ++i) scene->add_image(read_image(in));
  for (uint32_t i = 0; i < materials; ++i) {
    if (in.below(3) == 0)
      scene->add_shader(read_program(in, images));
    else
      scene->add_material(read_material(in));
  }
  for (uint32_t i = 0; i < meshes; ++i) scene->add_mesh(in.below(4) < 3 ? read_mesh(in) : read_strands(in));
  for (uint32_t i = 0; i < instances; ++i) {
    Instance instance{"instance",
                      in.byte() < 250 ? in.below(meshes) : in.below(9),
                      in.transform(),
                      {in.below(materials), in.byte() < 250 ? in.below(materials) : in.below(9)},
                      in.byte() < 200 ? kAnyRay : in.bits<RayMask>(),
                      in.byte() < 250 ? in.below(4) : in.bits<uint32_t>()};
    for (uint32_t time = read_times(in); time > 0; --time) instance.motion.push_back(in.transform());
    scene->add_instance(std::move(instance));
  }
  for (uint32_t i = 0; i < lights; ++i) read_luminaire(in, *scene);
  const RenderSettings settings = read_settings(in);
  auto [mesh_list, instance_list] = scene->release_geometry();
  const auto materials_of_scene = std::make_shared<const Materials>(scene);
  const auto geometry = std::make_shared<Geometry>(std::move(mesh_list), std::move(instance_list), 0,
                                                   scene->has_transparency() ? materials_of_scene : nullptr);
  Renderer renderer(scene, geometry, materials_of_scene, settings);
  // Now and then a second render of the same scene beside it: what they share must not be written to.
  std::optional<Renderer> twin;
  if (settings.seed % 4 == 0) twin.emplace(scene, geometry, materials_of_scene, settings);
  renderer.start();
  if (twin) twin->start();
  renderer.finish();
  check(renderer.film(), renderer.settings());
  if (!twin) return;
  twin->finish();
  for (const std::string& name : settings.passes)
    if (!std::ranges::equal(renderer.film().pass(name), twin->film().pass(name)))
      fail("two renders differ in " + name);
}

}  // namespace
}  // namespace penumbra

/// 184 bytes of each texture system are left on purpose (native/material/textures.cpp). Visible: a sanitizer
/// that is a library looks for it.
extern "C" __attribute__((visibility("default"))) const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:TextureSystem::create\n";
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  penumbra::fuzz::Bytes in(data, size);
  try {
    penumbra::render(in);
  } catch (const std::invalid_argument&) {  // a refusal: what should happen to nonsense
  }
  return 0;
}
