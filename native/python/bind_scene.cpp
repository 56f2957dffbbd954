// SPDX-License-Identifier: GPL-3.0-or-later
// penumbra_native.Scene: NumPy arrays and plain numbers in, a checked scene out.
#include <pybind11/stl.h>

#include <chrono>
#include <optional>
#include <stdexcept>

#include "python/arrays.h"
#include "python/bindings.h"
#include "python/name.h"
#include "scene/strands.h"
#include "visibility/placed_mesh.h"

namespace penumbra::python {
namespace {

using Color = std::array<double, 3>;
using Pair = std::array<double, 2>;
using ApertureNumbers = std::tuple<double, double, uint32_t, double, double>;

Vec3d vec(const Color& c) {
  return {c[0], c[1], c[2]};
}

Mesh read_mesh(const std::string& name, const py::array& positions, const py::array& triangles,
               const std::optional<py::array>& corner_normals, const std::optional<py::array>& material_slots,
               const std::map<uint32_t, py::array>& attributes) {
  Mesh mesh;
  mesh.name = name;
  mesh.positions = read_positions(positions, name);
  mesh.triangles = read_triangles(triangles, name);
  if (corner_normals) {
    mesh.normals_of_vertices = are_normals_of_vertices(*corner_normals, mesh.positions.size());
    if (!mesh.normals_of_vertices)
      check_shape(*corner_normals, {triangles.shape(0), 3, 3}, name, "corner_normals");
    mesh.corner_normals = read_corner_normals(*corner_normals, name);
  }
  if (material_slots) {
    check_shape(*material_slots, {triangles.shape(0)}, name, "material_slots");
    mesh.material_slots = read_slots(*material_slots, name);
  }
  for (const auto& [number, values] : attributes) {
    check_shape(values, {triangles.shape(0), 3, 4}, name, "attributes");
    mesh.attributes.push_back({number, read_attribute(values, name)});
  }
  return mesh;
}

using Attributes = std::map<uint32_t, py::array>;
using Arrays = std::vector<py::array>;

uint32_t add_mesh(PythonScene& self, const Name& name, const py::array& positions, const py::array& triangles,
                  const std::optional<py::array>& corner_normals,
                  const std::optional<py::array>& material_slots, const Attributes& attributes,
                  const Arrays& position_motion, const Arrays& normal_motion) {
  Mesh mesh = read_mesh(name, positions, triangles, corner_normals, material_slots, attributes);
  if (!normal_motion.empty() && normal_motion.size() != position_motion.size())
    throw py::value_error(name + ": position_motion and normal_motion do not match");
  for (size_t i = 0; i < position_motion.size(); ++i) {
    MeshPose pose{read_positions(position_motion[i], name), {}};
    if (!normal_motion.empty()) {
      if (!mesh.normals_of_vertices)
        check_shape(normal_motion[i], {kAny, 3, 3}, name, "corner_normals");
      else if (!are_normals_of_vertices(normal_motion[i], mesh.positions.size()))
        check_shape(normal_motion[i], {positions.shape(0), 3}, name, "corner_normals");
      pose.corner_normals = read_corner_normals(normal_motion[i], name);
    }
    mesh.motion.push_back(std::move(pose));
  }
  return self.scene->add_mesh(std::move(mesh));
}

Mesh read_strands(const std::string& name, const py::array& positions, const py::array& radii,
                  const Arrays& motion) {
  Mesh mesh;
  mesh.name = name;
  mesh.positions = read_positions(positions, name);
  check_shape(radii, {positions.shape(0)}, name, "radii");
  mesh.radii = read_floats(radii, name, "radii");
  for (const py::array& pose : motion) mesh.motion.push_back({read_positions(pose, name), {}});
  return mesh;
}

StrandShape shape_from_name(const std::string& name, const std::string& shape) {
  if (shape == "RIBBON") return StrandShape::kRibbon;
  if (shape == "TUBE") return StrandShape::kTube;
  throw py::value_error(name + ": shape is '" + shape + "', expected RIBBON or TUBE");
}

uint32_t add_curves(PythonScene& self, const Name& name, const py::array& keys, const py::array& radii,
                    const py::array& counts, const std::string& shape, const Arrays& motion) {
  Mesh mesh = read_strands(name, keys, radii, motion);
  mesh.strands = shape_from_name(name, shape);
  make_curves(mesh, read_counts(counts, name));
  return self.scene->add_mesh(std::move(mesh));
}

uint32_t add_points(PythonScene& self, const Name& name, const py::array& positions, const py::array& radii,
                    const Arrays& motion) {
  Mesh mesh = read_strands(name, positions, radii, motion);
  mesh.strands = StrandShape::kSphere;
  make_points(mesh);
  return self.scene->add_mesh(std::move(mesh));
}

std::vector<Affine> read_poses(const Arrays& poses, const std::string& name) {
  std::vector<Affine> result;
  for (const py::array& pose : poses) result.push_back(read_transform(pose, name, "motion"));
  return result;
}

uint32_t add_instance(PythonScene& self, const Name& name, uint32_t mesh, const py::array& world_from_object,
                      const std::vector<uint32_t>& materials, RayMask rays, uint32_t receiver_set,
                      const Arrays& motion) {
  Instance instance{name,      mesh, read_transform(world_from_object, name, "world_from_object"),
                    materials, rays, receiver_set};
  instance.motion = read_poses(motion, name);
  return self.scene->add_instance(std::move(instance));
}

std::shared_ptr<KeptMesh> keep(MeshStore& self, const Name& name, const py::array& positions,
                               const py::array& triangles, const std::optional<py::array>& corner_normals,
                               const std::optional<py::array>& material_slots, const Attributes& attributes) {
  Mesh mesh = read_mesh(name, positions, triangles, corner_normals, material_slots, attributes);
  check_mesh(mesh);
  return self.keep(std::move(mesh));
}

/// Meshes and textures that stay from scene to scene.
void bind_stores(py::module_& module) {
  py::class_<KeptMesh, std::shared_ptr<KeptMesh>>(module, "KeptMesh",
                                                  R"(A mesh with a ray tracing structure of its own.

It is built when a Render first needs it, and shared by all scenes that the mesh is added to.)")
      .def_property_readonly("name", &KeptMesh::name, "That of the object it was first kept for.");
  py::class_<TextureStore, std::shared_ptr<TextureStore>>(module, "TextureStore",
                                                          R"(The textures of the last scene built with it.

The next one uses them, and what was read of them, if its images are the same and their files have not changed.)")
      .def(py::init<>());
  py::class_<MeshStore>(module, "MeshStore", R"(Finds kept meshes by their content.

It holds none itself: a mesh goes with the last KeptMesh or Scene that has it. A scene's kept meshes must all be of one
store.)")
      .def(py::init<>())
      .def("keep", &keep, py::arg("name"), py::arg("positions"), py::arg("triangles"),
           py::arg("corner_normals") = py::none(), py::arg("material_slots") = py::none(),
           py::arg("attributes") = Attributes{},
           "The kept mesh of this content, one from before if there is one. Arguments and errors as of "
           "Scene.add_mesh.");
}

void set_camera(PythonScene& self, const std::string& kind, const py::array& world_from_camera,
                const std::array<double, 4>& window, const Pair& clip,
                const std::optional<ApertureNumbers>& aperture, const Arrays& motion,
                const std::vector<std::array<double, 4>>& window_motion, const std::vector<double>& shutter) {
  if (kind != "PERSPECTIVE" && kind != "ORTHOGRAPHIC")
    throw py::value_error("camera: kind is '" + kind + "', expected PERSPECTIVE or ORTHOGRAPHIC");
  Camera camera{kind == "PERSPECTIVE" ? CameraKind::kPerspective : CameraKind::kOrthographic,
                read_transform(world_from_camera, "camera", "world_from_camera"),
                {window[0], window[1], window[2], window[3]},
                clip[0],
                clip[1]};
  if (aperture) {
    const auto& [radius, focus_distance, blades, rotation, ratio] = *aperture;
    camera.aperture = {radius, focus_distance, blades, rotation, ratio};
  }
  camera.motion = read_poses(motion, "camera");
  for (const std::array<double, 4>& w : window_motion)
    camera.window_motion.push_back({w[0], w[1], w[2], w[3]});
  camera.shutter = shutter;
  self.scene->set_camera(camera);
}

/// "None" means no light group.
void set_traits(PythonScene& self, float pass_index, float object_matte, float asset_matte,
                const std::optional<uint32_t>& light_group, bool holdout, bool indirect_only) {
  self.scene->set_traits(
      {pass_index, object_matte, asset_matte, light_group.value_or(kNoLightGroup), holdout, indirect_only});
}

void bind_passes(py::class_<PythonScene>& scene) {
  scene
      .def(
          "add_light_group",
          [](PythonScene& self, const Name& name) { return self.scene->add_light_group(name); },
          py::arg("name"), "Adds a group of lights, which the pass Combined_NAME shows; returns its number.")
      .def("set_traits", &set_traits, py::arg("pass_index") = 0.0f, py::arg("object_matte") = 0.0f,
           py::arg("asset_matte") = 0.0f, py::arg("light_group") = py::none(), py::arg("holdout") = false,
           py::arg("indirect_only") = false,
           R"(What the instances and luminaires that are added from now on are to passes and to the film.

pass_index: of the pass Object Index. object_matte, asset_matte: Cryptomatte's ids. light_group: number of the group
that their light belongs to, None: of none. holdout: the camera sees a hole in the film in their place.
indirect_only: the camera does not see them.)")
      .def(
          "set_material_ids",
          [](PythonScene& self, uint32_t material, float pass_index, float matte) {
            self.scene->set_material_ids(material, pass_index, matte);
          },
          py::arg("material"), py::arg("pass_index"), py::arg("matte"),
          "What the pass Material Index shows of a material, and Cryptomatte's id of it.")
      .def(
          "set_uv_attribute",
          [](PythonScene& self, uint32_t number) { self.scene->set_uv_attribute(number); }, py::arg("number"),
          "Number of the meshes' attribute that the pass UV shows.");
}

}  // namespace

void PythonScene::build(uint64_t memory_limit) {
  if (geometry) return;
  const auto begin = std::chrono::steady_clock::now();
  auto [meshes, instances] = scene->release_geometry();
  materials = std::make_shared<const Materials>(std::make_shared<const Scene>(*scene), texture_store.get());
  geometry = std::make_shared<Geometry>(std::move(meshes), std::move(instances), memory_limit,
                                        scene->has_transparency() ? materials : nullptr);
  build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void bind_scene(py::module_& module) {
  bind_stores(module);
  py::class_<PythonScene> scene(module, "Scene",
                                R"(What is to be rendered, in world space (metres), double precision.

Every method raises ValueError with the object's name in the text where its arguments make no sense. Arrays are
copied. Once a Render was made of the scene, meshes and instances are fixed; the rest may still change.)");
  bind_material(module, scene);
  bind_luminaires(module, scene);
  scene
      .def(py::init([](const std::optional<std::shared_ptr<TextureStore>>& textures) {
             PythonScene made;
             made.texture_store = textures.value_or(nullptr);
             return made;
           }),
           py::arg("textures") = py::none())
      .def("add_mesh", &add_mesh, py::arg("name"), py::arg("positions"), py::arg("triangles"),
           py::arg("corner_normals") = py::none(), py::arg("material_slots") = py::none(),
           py::arg("attributes") = Attributes{}, py::arg("position_motion") = Arrays{},
           py::arg("normal_motion") = Arrays{},
           R"(Adds triangles in object space and returns the mesh's number.

positions: (V, 3) float32 or float64. triangles: (T, 3) integers, vertex indices. corner_normals: (T, 3, 3) float
in object space, or (V, 3) where all corners at a vertex share one, or None for flat shading. material_slots: (T,) integers, or None for slot 0. attributes: by number,
(T, 3, 4) float at each corner: what programs read by that number. position_motion: positions at 2 to 129 evenly spaced
times from the shutter's opening to its closing, linear in between; normal_motion: corner_normals at these times.)")
      .def("add_curves", &add_curves, py::arg("name"), py::arg("keys"), py::arg("radii"), py::arg("counts"),
           py::arg("shape"), py::arg("motion") = Arrays{},
           R"(Adds strands, cubic Catmull-Rom curves, in object space and returns their number as a mesh's.

keys: (K, 3) floating point, those of all strands one after the other. radii: (K,) floating point. counts: (S,) integers,
keys of each strand. shape: RIBBON, turned to each ray and shaded as round, or TUBE. motion: keys at times as in
add_mesh.)")
      .def("add_points", &add_points, py::arg("name"), py::arg("positions"), py::arg("radii"),
           py::arg("motion") = Arrays{},
           "Adds spheres, (N, 3) and (N,), in object space and returns their number as a mesh's. motion: as "
           "in "
           "add_mesh.")
      .def(
          "add_kept_mesh",
          [](PythonScene& self, const Name& name, const std::shared_ptr<KeptMesh>& mesh) {
            return self.scene->add_kept_mesh(mesh, name, mesh->hash());
          },
          py::arg("name"), py::arg("mesh").none(false), "Adds a mesh that is kept and returns its number.")
      .def(
          "add_material",
          [](PythonScene& self, const Name& name, const Color& diffuse, const Color& phong, double exponent,
             const Color& mirror) {
            Material material;
            material.name = name;
            material.diffuse = vec(diffuse);
            material.phong = vec(phong);
            material.phong_exponent = exponent;
            material.mirror = vec(mirror);
            return self.scene->add_material(std::move(material));
          },
          py::arg("name"), py::arg("diffuse"), py::arg("phong") = Color{0, 0, 0},
          py::arg("phong_exponent") = 0.0, py::arg("mirror") = Color{0, 0, 0},
          R"(Adds the paper's BRDF, mirror + Phong + diffuse, by its albedos (r, g, b), which may add up to 1 at most.

Returns the material's number.)")
      .def(
          "add_instance", &add_instance, py::arg("name"), py::arg("mesh"), py::arg("world_from_object"),
          py::arg("materials"), py::arg("rays") = kAnyRay, py::arg("receiver_set") = 0,
          py::arg("motion") = Arrays{},
          R"(Places a mesh and returns the instance's number. world_from_object: (4, 4) float64. materials: numbers of
materials, one a slot; slots beyond the end use the last one. rays: the kinds of rays that it is there for, a sum of CAMERA_RAY, MIRROR_RAY, SHADOW_RAY and
blocker_set_ray(n). receiver_set: a number that LuminaireRole.receivers
refers to. motion: the transform at 2 to 129 evenly spaced times from the shutter's opening to its closing, turned at
even speed in between; empty where it stands still. world_from_object is then that of the shutter's centre.)")
      .def(
          "set_camera", &set_camera, py::arg("kind"), py::arg("world_from_camera"), py::arg("window"),
          py::arg("clip"), py::arg("aperture") = py::none(), py::arg("motion") = Arrays{},
          py::arg("window_motion") = std::vector<std::array<double, 4>>{},
          py::arg("shutter") = std::vector<double>{},
          R"(kind: PERSPECTIVE or ORTHOGRAPHIC, looking along local -z. window: (left, right, bottom, top) of the full
frame, in the plane z = -1 or in world units. clip: (start, end) along the view axis. aperture: (radius, focus
distance, blades, rotation, ratio) of a thin lens, lengths in world units and the rotation in radians; round below
three blades, its height `ratio` times its width. One ray a pixel goes through its middle. motion, window_motion: transform and window at
as many times as of an instance. shutter: how far it is open at evenly spaced times, in any unit; empty: wholly. One ray a pixel sees the
scene at the shutter's centre.)")
      .def_property_readonly(
          "is_lit",
          [](const PythonScene& self) {
            const Background& background = self.scene->background();
            return !self.scene->luminaires().empty() || !self.scene->textured_luminaires().empty() ||
                   (background.lights && max_abs(background.color) > 0);
          },
          "Whether there is any luminaire, or a background that lights.");
  bind_passes(scene);
}

}  // namespace penumbra::python
