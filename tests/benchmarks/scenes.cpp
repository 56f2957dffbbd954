// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes.h"

#include <cmath>
#include <ctime>
#include <numbers>

#include "sampling/hash.h"

namespace penumbra::benchmark {
namespace {

constexpr double kPi = std::numbers::pi;

/// Uniform variate in [0, 1) that depends on its arguments alone.
double variate(uint64_t index, uint64_t dimension) {
  return double(hash_of(index, dimension) >> 11) * 0x1p-53;
}

/// A surface over a grid of (columns x rows) quadrilaterals; `closed` joins the last column to the first.
template <typename Function>
Mesh grid(const std::string& name, uint32_t columns, uint32_t rows, Function position) {
  Mesh mesh;
  mesh.name = name;
  for (uint32_t j = 0; j <= rows; ++j)
    for (uint32_t i = 0; i <= columns; ++i)
      mesh.positions.push_back(position(double(i) / columns, double(j) / rows));
  for (uint32_t j = 0; j < rows; ++j) {
    for (uint32_t i = 0; i < columns; ++i) {
      const uint32_t a = j * (columns + 1) + i, b = a + columns + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  }
  return mesh;
}

Mesh plane(double half) {
  return grid("floor", 1, 1, [=](double u, double v) {
    return Vec3d{half * (2 * u - 1), half * (2 * v - 1), 0};
  });
}

Mesh sphere(uint32_t rows) {
  return grid("sphere", 2 * rows, rows, [](double u, double v) {
    const double theta = kPi * (1 - v), phi = 2 * kPi * u;
    return Vec3d{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
  });
}

Mesh torus(uint32_t rows) {
  return grid("torus", 2 * rows, rows, [](double u, double v) {
    const double a = 2 * kPi * u, b = 2 * kPi * v, r = 1 + 0.35 * std::cos(b);
    return Vec3d{r * std::cos(a), r * std::sin(a), 0.35 * std::sin(b)};
  });
}

Mesh cone(uint32_t columns) {
  return grid("cone", columns, 1, [](double u, double v) {
    return Vec3d{(1 - v) * std::cos(2 * kPi * u), (1 - v) * std::sin(2 * kPi * u), 2 * v};
  });
}

Mesh box() {
  Mesh mesh;
  mesh.name = "box";
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back({i & 1 ? 1. : -1., i & 2 ? 1. : -1., i & 4 ? 1. : -1.});
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// A bush: a small sphere as its fruit, and leaves of two triangles around it, in the unit ball.
Mesh bush(uint64_t seed, uint32_t leaves) {
  Mesh mesh = sphere(7);
  for (Vec3d& p : mesh.positions) p = p * 0.3;
  for (uint32_t i = 0; i < leaves; ++i) {
    const uint64_t k = seed * 1000003 + i;
    const auto direction = [&](uint64_t d) {
      return normalize(Vec3d{variate(k, d) - 0.5, variate(k, d + 1) - 0.5, variate(k, d + 2) - 0.5});
    };
    const Vec3d centre = direction(0) * std::cbrt(variate(k, 9)), a = direction(3) * 0.12,
                b = direction(6) * 0.05;
    const auto first = uint32_t(mesh.positions.size());
    for (const Vec3d& corner : {centre - a, centre + b, centre + a, centre - b})
      mesh.positions.push_back(corner);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  }
  return mesh;
}

Affine placed(const Vec3d& at, double scale, double turn = 0) {
  const double c = std::cos(turn) * scale, s = std::sin(turn) * scale;
  return {{c, s, 0}, {-s, c, 0}, {0, 0, scale}, at};
}

/// Camera at `eye` looking at `target`, z upwards, horizontal half field of view tan = 0.5, 4:3.
void look(Scene& scene, const Vec3d& eye, const Vec3d& target) {
  const Vec3d back = normalize(eye - target), right = normalize(cross(Vec3d{0, 0, 1}, back));
  scene.set_camera({CameraKind::kPerspective,
                    {right, cross(back, right), back, eye},
                    {-0.5, 0.5, -0.375, 0.375},
                    0.01,
                    1000});
}

Scene stage(double floor, double light_height, double light_side) {
  Scene scene;
  Material grey;
  grey.name = "grey";
  grey.diffuse = {0.7, 0.7, 0.7};
  scene.add_material(grey);
  scene.add_instance({"floor", scene.add_mesh(plane(floor)), {}, {0}});
  const double radiance = light_height * light_height / (light_side * light_side);
  scene.add_luminaire({"light",
                       LuminaireShape::kRectangle,
                       placed({1, -1, light_height}, 1),
                       light_side,
                       light_side,
                       {radiance, radiance, radiance}});
  look(scene, {6, -9, 6}, {0, 0, 0.7});
  return scene;
}

void add(Scene& scene, Mesh mesh, const Affine& world_from_object) {
  const std::string name = mesh.name;
  const uint32_t id = scene.add_mesh(std::move(mesh));
  scene.add_instance({name, id, world_from_object, {0}});
}

Scene open_floor() {
  return stage(20, 6, 2);
}

Scene sphere_on_floor() {
  Scene scene = stage(20, 6, 2);
  add(scene, sphere(36), placed({0, 0, 1}, 1));
  return scene;
}

void add_four_objects(Scene& scene) {
  add(scene, sphere(40), placed({-1.6, 1.2, 1}, 1));
  add(scene, torus(36), placed({1.6, 1.3, 0.35}, 1));
  add(scene, cone(64), placed({1.5, -1.6, 0}, 1));
  add(scene, box(), placed({-1.6, -1.5, 0.8}, 0.8, 0.5));
}

Scene four_objects() {
  Scene scene = stage(20, 6, 2);
  add_four_objects(scene);
  return scene;
}

/// On a floor of light and dark squares.
Scene checker() {
  Scene scene = stage(1e-3, 6, 2);
  Material dark;
  dark.name = "dark";
  dark.diffuse = {0.25, 0.25, 0.25};
  scene.add_material(dark);
  constexpr uint32_t kSquares = 40;
  Mesh squares = grid("squares", kSquares, kSquares, [](double u, double v) {
    return Vec3d{20 * (2 * u - 1), 20 * (2 * v - 1), 0};
  });
  for (uint32_t i = 0; i < squares.triangles.size(); ++i)
    squares.material_slots.push_back((i / 2 % kSquares + i / 2 / kSquares) % 2);
  scene.add_instance({"squares", scene.add_mesh(std::move(squares)), {}, {0, 1}});
  add_four_objects(scene);
  return scene;
}

/// Bars, and wires down to an eighth of a pixel.
Scene wires() {
  Scene scene = stage(20, 6, 2);
  const auto add_bar = [&](const Vec3d& half, const Vec3d& at, double turn) {
    Affine place = placed(at, 1, turn);
    place.x_axis = place.x_axis * half.x;
    place.y_axis = place.y_axis * half.y;
    place.z_axis = place.z_axis * half.z;
    add(scene, box(), place);
  };
  for (int i = 0; i < 40; ++i) add_bar({0.02, 0.015, 0.8}, {-3 + 0.15 * i, 0, 0.8}, 0);
  for (uint64_t i = 0; i < 20; ++i) {
    const double half = 0.001 + 0.01 * variate(i, 200);
    add_bar({2, half, half}, {4 * variate(i, 201) - 2, 4 * variate(i, 202) - 2, 0.3 + 1.2 * variate(i, 203)},
            kPi * variate(i, 204));
  }
  return scene;
}

constexpr uint32_t kBushes = 2000, kLeaves = 160;

/// Instances share one of 16 bushes; otherwise each has its own.
Scene field(bool instanced) {
  Scene scene = stage(20, 8, 3);
  std::vector<uint32_t> shared;
  for (uint32_t i = 0; i < 16 && instanced; ++i) shared.push_back(scene.add_mesh(bush(i, kLeaves)));
  for (uint32_t i = 0; i < kBushes; ++i) {
    const double x = 8 * (2 * variate(i, 100) - 1), y = 8 * (2 * variate(i, 101) - 1);
    const Affine at = placed({x, y, 0.25}, 0.2 + 0.2 * variate(i, 102), 6.28 * variate(i, 103));
    const uint32_t mesh = instanced ? shared[i % 16] : scene.add_mesh(bush(i, kLeaves));
    scene.add_instance({"bush", mesh, at, {0}});
  }
  return scene;
}

}  // namespace

Mesh bumpy_floor(uint32_t triangles, bool smooth) {
  const auto side = uint32_t(std::lround(std::sqrt(triangles / 2.0)));
  Mesh mesh = grid("floor", side, side, [](double u, double v) {
    return Vec3d{20 * (2 * u - 1), 20 * (2 * v - 1), 0.3 * std::sin(40 * u) * std::cos(50 * v)};
  });
  for (size_t i = 0; smooth && i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const Vec3d& a = mesh.positions[t[0]];
    const Vec3f normal(normalize(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a)));
    mesh.corner_normals.insert(mesh.corner_normals.end(), 3, normal);
  }
  mesh.positions.shrink_to_fit();
  mesh.triangles.shrink_to_fit();
  mesh.corner_normals.shrink_to_fit();
  return mesh;
}

Scene under_a_rectangle(Mesh mesh) {
  Scene scene = stage(1e-3, 6, 2);
  add(scene, std::move(mesh), {});
  return scene;
}

const std::vector<NamedScene>& scenes() {
  static const std::vector<NamedScene> list{{"open floor", open_floor},
                                            {"sphere on floor", sphere_on_floor},
                                            {"four objects", four_objects},
                                            {"checker", checker},
                                            {"wires", wires},
                                            {"plants, 1 M triangles", [] { return field(false); }},
                                            {"plants, instanced", [] { return field(true); }}};
  return list;
}

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

}  // namespace penumbra::benchmark
