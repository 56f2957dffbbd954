// SPDX-License-Identifier: GPL-3.0-or-later
// What gives light, of penumbra_native.Scene: luminaires and the background.
#include <pybind11/stl.h>

#include <cstring>
#include <numbers>
#include <variant>

#include "luminaire/flat_emitter.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/name.h"

namespace penumbra::python {
namespace {

using Color = std::array<double, 3>;
using Pair = std::array<double, 2>;

Vec3d vec(const Color& c) {
  return {c[0], c[1], c[2]};
}

LuminaireShape shape_from_name(const std::string& shape, const std::string& name) {
  if (shape == "RECTANGLE") return LuminaireShape::kRectangle;
  if (shape == "ELLIPSE") return LuminaireShape::kEllipse;
  throw py::value_error(name + ": shape is '" + shape + "', expected RECTANGLE or ELLIPSE");
}

void add_area_light(PythonScene& self, const Name& name, const std::string& shape,
                    const py::array& world_from_light, const Pair& size, const Color& radiance,
                    bool cast_shadow, double spread, const LuminaireRole& role) {
  self.scene->add_luminaire(AreaLuminaire{name, shape_from_name(shape, name),
                                          read_transform(world_from_light, name, "world_from_light"), size[0],
                                          size[1], vec(radiance), cast_shadow, spread, role});
}

RoundShape round_shape_from_name(const std::string& shape, const std::string& name) {
  if (shape == "SPHERE") return RoundShape::kSphere;
  if (shape == "FACING_DISK") return RoundShape::kFacingDisk;
  throw py::value_error(name + ": shape is '" + shape + "', expected SPHERE or FACING_DISK");
}

void add_point_light(PythonScene& self, const Name& name, const py::array& world_from_light, double radius,
                     const Color& intensity, bool cast_shadow, const std::string& shape,
                     const std::optional<Pair>& spot, bool cosine_falloff, const LuminaireRole& role) {
  PointLuminaire light{name,
                       round_shape_from_name(shape, name),
                       read_transform(world_from_light, name, "world_from_light"),
                       radius,
                       vec(intensity),
                       cast_shadow,
                       {},
                       role};
  if (spot) light.spot = SpotCone{(*spot)[0], (*spot)[1], cosine_falloff};
  self.scene->add_luminaire(std::move(light));
}

std::shared_ptr<SkyPicture> sky_picture(const py::array& image) {
  std::vector<Vec3f> pixels = read_colors(image, "background", "image");
  return std::make_shared<SkyPicture>(uint32_t(image.shape(1)), uint32_t(image.shape(0)), std::move(pixels));
}

using AnyPicture = std::variant<std::shared_ptr<SkyPicture>, py::array>;

void set_background(PythonScene& self, const Color& color, bool transparent, bool lights, bool seen_by_camera,
                    const std::optional<AnyPicture>& image, const std::optional<py::array>& local_from_world,
                    bool smooth, const std::optional<uint32_t>& light_group) {
  Background background{vec(color), transparent,    {},
                        lights,     seen_by_camera, light_group.value_or(kNoLightGroup)};
  if (image) {
    const auto sky = std::make_shared<Environment>();
    const auto* made = std::get_if<std::shared_ptr<SkyPicture>>(&*image);
    sky->picture = made ? *made : sky_picture(std::get<py::array>(*image));
    sky->smooth = smooth;
    if (local_from_world)
      sky->local_from_world = read_transform(*local_from_world, "background", "local_from_world");
    background.environment = sky;
  }
  self.scene->set_background(background);
}

}  // namespace

void bind_luminaires(py::module_& module, py::class_<PythonScene>& scene) {
  py::class_<LuminaireRole>(module, "LuminaireRole",
                            R"(What a luminaire is to rays and surfaces, beside its light.

to_camera, in_mirrors: it is seen itself there (a mesh is a surface and seen as such). diffuse, glossy: which lobes of
surfaces it lights. shadow_rays: the kind of its shadow rays, SHADOW_RAY or blocker_set_ray(n). receivers: for each
receiver set of add_instance, whether it lights those instances; empty: all.)")
      .def(py::init([](bool to_camera, bool in_mirrors, bool diffuse, bool glossy, RayMask shadow_rays,
                       std::vector<bool> receivers) {
             return LuminaireRole{to_camera, in_mirrors, diffuse, glossy, shadow_rays, std::move(receivers)};
           }),
           py::kw_only(), py::arg("to_camera") = false, py::arg("in_mirrors") = false,
           py::arg("diffuse") = true, py::arg("glossy") = true, py::arg("shadow_rays") = kShadowRay,
           py::arg("receivers") = std::vector<bool>{})
      .def_readonly("to_camera", &LuminaireRole::to_camera)
      .def_readonly("in_mirrors", &LuminaireRole::in_mirrors)
      .def_readonly("diffuse", &LuminaireRole::diffuse)
      .def_readonly("glossy", &LuminaireRole::glossy)
      .def_readonly("shadow_rays", &LuminaireRole::shadow_rays)
      .def_readonly("receivers", &LuminaireRole::receivers)
      .def("__repr__", [](const LuminaireRole& r) {
        std::string text = "LuminaireRole(";
        for (const auto& [name, value] : {std::pair{"to_camera", r.to_camera},
                                          {"in_mirrors", r.in_mirrors},
                                          {"diffuse", r.diffuse},
                                          {"glossy", r.glossy}})
          text += std::string(name) + "=" + (value ? "True, " : "False, ");
        return text + "shadow_rays=" + std::to_string(r.shadow_rays) + ")";
      });
  py::class_<SkyPicture, std::shared_ptr<SkyPicture>>(module, "SkyPicture",
                                                      R"(A picture of the whole sky, shared by scenes.

image: (height, width, 3) float, equirectangular, scene linear, rows from straight down up, columns from azimuth pi down to
-pi. What it gives as a light is made once. ValueError where it has no pixels, or not finite ones.)")
      .def(py::init(&sky_picture), py::arg("image"))
      .def_property_readonly(
          "pixels",
          [](const SkyPicture& self) {
            py::array_t<float> copy({self.height(), self.width(), 3u});
            std::memcpy(copy.mutable_data(), self.pixels().data(), size_t(copy.nbytes()));
            return copy;
          },
          "(height, width, 3) float32, a copy.");
  module.attr("CAMERA_RAY") = kCameraRay;
  module.attr("MIRROR_RAY") = kMirrorRay;
  module.attr("SHADOW_RAY") = kShadowRay;
  module.attr("ANY_RAY") = kAnyRay;
  module.attr("MOST_BLOCKER_SETS") = kMostBlockerSets;
  module.def(
      "blocker_set_ray",
      [](uint32_t set) {
        if (set >= kMostBlockerSets) throw py::value_error("there are no more than 29 sets of blockers");
        return blocker_set_ray(set);
      },
      py::arg("set"),
      "The kind of shadow rays that set number `set`, 0 ... MOST_BLOCKER_SETS - 1, of instances blocks.");
  scene
      .def("add_area_light", &add_area_light, py::arg("name"), py::arg("shape"), py::arg("world_from_light"),
           py::arg("size"), py::arg("radiance"), py::arg("cast_shadow") = true,
           py::arg("spread") = std::numbers::pi, py::arg("role") = LuminaireRole{},
           R"(Adds a flat, one-sided luminaire in its local xy plane, emitting towards local -z.

shape: RECTANGLE or ELLIPSE. size: full extents (x, y) before the transform. radiance: (r, g, b), W/(sr m^2). spread:
full angle of the cone that light leaves in, radians; the power stays that of pi.)")
      .def("add_point_light", &add_point_light, py::arg("name"), py::arg("world_from_light"),
           py::arg("radius"), py::arg("intensity"), py::arg("cast_shadow") = true,
           py::arg("shape") = "SPHERE", py::arg("spot") = py::none(), py::arg("cosine_falloff") = false,
           py::arg("role") = LuminaireRole{},
           R"(Adds a luminaire around a point, of radiance intensity / (pi radius^2).

radius: world units; 0 is a point. intensity: (r, g, b), W/sr. shape: SPHERE, or FACING_DISK, a disk that faces whoever
looks at it. spot: (full angle in radians, blend 0 ... 1) of a cone around local -z, None for light in all directions;
cosine_falloff multiplies it with the cosine to the axis.)")
      .def(
          "add_sun",
          [](PythonScene& self, const Name& name, const Color& to_sun, double angle, const Color& irradiance,
             bool cast_shadow, const LuminaireRole& role) {
            self.scene->add_luminaire(
                SunLuminaire{name, vec(to_sun), angle / 2, vec(irradiance), cast_shadow, role});
          },
          py::arg("name"), py::arg("to_sun"), py::arg("angle"), py::arg("irradiance"),
          py::arg("cast_shadow") = true, py::arg("role") = LuminaireRole{},
          R"(Adds a disk of directions of constant radiance, infinitely far away.

to_sun: direction (x, y, z). angle: diameter in radians, 0 ... pi; 0 is one direction. irradiance: (r, g, b), W/m^2 of a
surface that faces it.)")
      .def(
          "add_mesh_light",
          [](PythonScene& self, const Name& name, const py::array& positions, const py::array& triangles,
             const py::array& world_from_object, const Color& radiance, bool cast_shadow,
             const LuminaireRole& role) {
            MeshLuminaire light{name,
                                read_positions(positions, name),
                                read_triangles(triangles, name),
                                vec(radiance),
                                cast_shadow,
                                role};
            const Affine t = read_transform(world_from_object, name, "world_from_object");
            for (Vec3d& p : light.positions) p = t.point(p);
            self.scene->add_luminaire(std::move(light));
          },
          py::arg("name"), py::arg("positions"), py::arg("triangles"), py::arg("world_from_object"),
          py::arg("radiance"), py::arg("cast_shadow") = true, py::arg("role") = LuminaireRole{},
          R"(Adds triangles as one luminaire that emits on both sides; they should be part of a mesh of the scene, too.

Arguments as of add_mesh and add_instance. radiance: (r, g, b), W/(sr m^2).)")
      .def(
          "add_textured_mesh_light",
          [](PythonScene& self, const Name& name, uint32_t instance, const LuminaireRole& role) {
            self.scene->add_luminaire(TexturedLuminaire{name, instance, role});
          },
          py::arg("name"), py::arg("instance"), py::arg("role") = LuminaireRole{},
          "Makes luminaires of an instance's triangles whose materials' emission varies (see emission_of).")
      .def_static(
          "area_of",
          [](const std::string& shape, const py::array& world_from_light, const Pair& size) {
            return area_of(shape_from_name(shape, "area_of"),
                           read_transform(world_from_light, "area_of", "world_from_light"), size[0], size[1]);
          },
          py::arg("shape"), py::arg("world_from_light"), py::arg("size"),
          "True area |M x_axis x M y_axis| of a luminaire, m^2.")
      .def("set_background", &set_background, py::arg("color"), py::arg("transparent") = false,
           py::arg("lights") = false, py::arg("seen_by_camera") = true, py::arg("image") = py::none(),
           py::arg("local_from_world") = py::none(), py::arg("smooth") = true,
           py::arg("light_group") = py::none(),
           R"(What is seen where nothing is hit; transparent: alpha 0 there for the camera.

color: radiance (r, g, b), or what an image is multiplied with. lights: it lights the scene. image: a SkyPicture, or
the array of one. local_from_world: (4, 4) float64, its rotation. smooth: interpolated between pixels' centres. light_group: number, None: of none.)");
}

}  // namespace penumbra::python
