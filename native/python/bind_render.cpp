// SPDX-License-Identifier: GPL-3.0-or-later
// penumbra_native.Render: a render in progress, its pixels and its statistics.
#include <pybind11/stl.h>

#include "math/simd.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "render/renderer.h"

namespace penumbra::python {
namespace {

/// Reads one setting: the value's type is checked, and an error names the setting.
template <typename T>
T setting(const py::dict& given, const char* name, const T& standard) {
  if (!given.contains(name)) return standard;
  const py::object value = given[name];
  // Bytes would do for text, but need not be any that an error message can hold.
  bool is_bytes = py::isinstance<py::bytes>(value);
  if (py::isinstance<py::list>(value))
    for (const auto& element : value) is_bytes = is_bytes || py::isinstance<py::bytes>(element);
  try {
    if (!is_bytes) return value.cast<T>();
  } catch (const py::cast_error&) {  // told below
  }
  throw py::value_error(std::string(name) + " is " + py::repr(value).cast<std::string>() +
                        ", which is out of range or of the wrong type");
}

RenderSettings read_settings(const py::dict& given) {
  static const std::vector<std::string> known{"width",
                                              "height",
                                              "region",
                                              "stop_rule",
                                              "sampler",
                                              "sample_reuse",
                                              "light_samples",
                                              "max_light_samples",
                                              "check_interval",
                                              "pixel_samples",
                                              "max_pixel_samples",
                                              "filter_type",
                                              "filter_width",
                                              "mirror_depth",
                                              "seed",
                                              "error_tolerance",
                                              "exposure",
                                              "threads",
                                              "passes",
                                              "mist",
                                              "memory_limit",
                                              "checkpoint"};
  for (const auto& item : given) {
    const auto name = py::str(item.first).cast<std::string>();
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw py::value_error("there is no setting named '" + name + "'");
  }
  RenderSettings s;
  s.width = setting(given, "width", s.width);
  s.height = setting(given, "height", s.height);
  if (given.contains("region")) {
    const auto r = setting(given, "region", std::array<uint32_t, 4>{});
    if (r[2] == 0 || r[3] == 0) throw py::value_error("region is empty");
    s.region = {r[0], r[1], r[2], r[3]};
  }
  s.stop_rule = stop_rule_from_name(setting<std::string>(given, "stop_rule", "BOUNDED"));
  s.sampler = sampler_from_name(setting<std::string>(given, "sampler", "OWEN_SOBOL"));
  s.sample_reuse = reuse_from_name(setting<std::string>(given, "sample_reuse", "SCRAMBLED"));
  s.filter_type = filter_from_name(setting<std::string>(given, "filter_type", "BLACKMAN_HARRIS"));
  s.light_samples = setting(given, "light_samples", s.light_samples);
  s.max_light_samples = setting(given, "max_light_samples", s.max_light_samples);
  s.check_interval = setting(given, "check_interval", s.check_interval);
  s.pixel_samples = setting(given, "pixel_samples", s.pixel_samples);
  s.max_pixel_samples = setting(given, "max_pixel_samples", s.max_pixel_samples);
  s.filter_width = setting(given, "filter_width", s.filter_width);
  s.mirror_depth = setting(given, "mirror_depth", s.mirror_depth);
  // Blender's seeds are signed; all 32 bits count.
  s.seed = uint32_t(setting<int64_t>(given, "seed", 0));
  s.error_tolerance = setting(given, "error_tolerance", s.error_tolerance);
  s.exposure = setting(given, "exposure", s.exposure);
  s.threads = setting(given, "threads", s.threads);
  const auto mist = setting(given, "mist", std::array{s.mist.start, s.mist.depth, s.mist.exponent});
  s.mist = {mist[0], mist[1], mist[2]};
  s.memory_limit = setting(given, "memory_limit", s.memory_limit);
  s.checkpoint = setting(given, "checkpoint", s.checkpoint);
  s.build = std::string(kVersion) + " (" + PENUMBRA_BUILD + ", " + vector_isa() + ")";
  s.passes = setting(given, "passes", s.passes);
  if (std::find(s.passes.begin(), s.passes.end(), "Combined") == s.passes.end())
    s.passes.emplace_back("Combined");
  return s;
}

/// Keeps what the renderer reads alive, and remembers what statistics need.
class PythonRender {
 public:
  PythonRender(PythonScene& scene, const py::dict& settings) {
    const RenderSettings read = read_settings(settings).validated();
    scene.scene->camera();  // refuses a scene without one before the long part
    {
      const py::gil_scoped_release release;
      scene.build(uint64_t(read.memory_limit) << 20);
      renderer_ = std::make_unique<Renderer>(std::make_shared<const Scene>(*scene.scene), scene.geometry,
                                             scene.materials, read);
    }
    geometry_ = scene.geometry;
    materials_ = scene.materials;
    build_seconds_ = scene.build_seconds;
    scene_hash_ = scene.scene->hash();
    luminaires_ = scene.scene->luminaires().size() + scene.scene->textured_luminaires().size();
  }

  Renderer& renderer() { return *renderer_; }

  py::array_t<float> read(const std::string& name, uint32_t x, uint32_t y, uint32_t width,
                          uint32_t height) const {
    const Film& film = renderer_->film();
    const Rectangle& region = film.region();
    if (uint64_t(x) + width > region.width || uint64_t(y) + height > region.height)
      throw py::value_error("the block reaches beyond the rendered region");
    return copy_block(film.pass(name), region.width, pass_channels(name), x, y, width, height);
  }

  /// The film's own memory; owner: this object's Python side.
  py::array_t<float> view(const py::object& owner, const std::string& name) const {
    const Film& film = renderer_->film();
    const auto channels = py::ssize_t(pass_channels(name));
    const std::span<const float> values = film.pass(name);
    py::array_t<float> result({py::ssize_t(values.size()) / channels, channels}, values.data(), owner);
    result.attr("setflags")(py::arg("write") = false);
    return result;
  }

  py::dict passes() const {
    py::dict result;
    const Rectangle& region = renderer_->film().region();
    for (const std::string& name : renderer_->settings().passes) {
      py::array block = read(name, 0, 0, region.width, region.height);
      result[py::str(name)] =
          block.reshape({py::ssize_t(region.height), py::ssize_t(region.width), py::ssize_t(-1)});
    }
    return result;
  }

  py::dict statistics() const {
    using py::literals::operator""_a;
    const RenderStatistics& s = renderer_->statistics();
    const RenderTally& t = s.tally;
    char hash[17];
    std::snprintf(hash, sizeof(hash), "%016llx", static_cast<unsigned long long>(scene_hash_));
    std::vector<std::string> warnings = geometry_->notes();
    for (std::string& text : materials_->problems()) warnings.push_back(std::move(text));
    if (t.non_finite_pixels)
      warnings.push_back(std::to_string(t.non_finite_pixels) +
                         " pixels were not finite and are black, the first is " + t.first_non_finite);
    return py::dict(
        "version"_a = kVersion, "build"_a = PENUMBRA_BUILD, "isa"_a = vector_isa(),
        "scene_hash"_a = std::string(hash), "triangles"_a = geometry_->triangles(),
        "meshes"_a = geometry_->meshes(), "instances"_a = geometry_->instances(),
        "luminaires"_a = luminaires_,
        "seconds"_a = py::dict("build"_a = build_seconds_, "render"_a = s.seconds),
        "primary_rays"_a = t.primary_rays, "mirror_rays"_a = t.mirror_rays,
        "shadow_rays"_a = t.light.shadow_rays, "shadow_rays_beyond_stop"_a = t.light.shadow_rays_beyond_stop,
        "light_points"_a = t.light.light_points, "light_lines"_a = t.light.light_lines,
        "points_without_ray"_a = t.light.decided_without_ray, "pixels_at_sample_limit"_a = t.pixels_at_limit,
        "non_finite_pixels"_a = t.non_finite_pixels,
        "error_tolerance"_a = renderer_->settings().error_tolerance,
        "error_estimate"_a = py::dict("mean"_a = s.error_mean, "p99"_a = s.error_p99, "max"_a = s.error_max),
        "warnings"_a = warnings);
  }

 private:
  std::shared_ptr<const Geometry> geometry_;
  std::shared_ptr<const Materials> materials_;
  std::unique_ptr<Renderer> renderer_;
  double build_seconds_ = 0;
  uint64_t scene_hash_ = 0;
  size_t luminaires_ = 0;
};

}  // namespace

void bind_render(py::module_& module) {
  using Released = py::call_guard<py::gil_scoped_release>;
  py::class_<PythonRender>(module, "Render", R"(One render of a scene.

settings: a dict with width and height in pixels, and any of the add-on's settings by their names; further `region`
(x, y, width, height), `exposure` (stops), `threads` (0: all) and `passes` (names). Raises ValueError that names the
setting. Building the acceleration structure happens here, once a scene; RuntimeError or MemoryError if it fails.)")
      .def(py::init<PythonScene&, const py::dict&>(), py::arg("scene"), py::arg("settings"),
           py::keep_alive<1, 2>())
      .def(
          "start", [](PythonRender& self) { self.renderer().start(); },
          "Starts the threads and returns at once.")
      .def(
          "wait",
          [](PythonRender& self, double seconds) {
            std::vector<Rectangle> finished;
            {
              const py::gil_scoped_release release;
              finished = self.renderer().wait(seconds);
            }
            py::list result;
            for (const Rectangle& r : finished) result.append(py::make_tuple(r.x, r.y, r.width, r.height));
            return result;
          },
          py::arg("seconds"),
          "Waits at most so long; returns the blocks (x, y, width, height) finished since, bottom left "
          "origin, in the region.")
      .def(
          "cancel", [](PythonRender& self) { self.renderer().cancel(); },
          "Asks the threads to stop, which they do within milliseconds; blocks under way are not kept.")
      .def(
          "finish", [](PythonRender& self) { self.renderer().finish(); }, Released(),
          "Waits for the threads. Raises what failed in one of them. May be called again.")
      .def(
          "debug_pixel",
          [](PythonRender& self, uint32_t x, uint32_t y) { return self.renderer().debug_pixel(x, y); },
          py::arg("x"), py::arg("y"), Released(),
          "Lines of text on one pixel of the full frame (origin bottom left): what it sees, and for each "
          "luminaire its "
          "form factor, which points are seen, and what lighting decided. Before start() only.")
      .def_property_readonly("done", [](PythonRender& self) { return self.renderer().done(); })
      .def_property_readonly(
          "progress", [](PythonRender& self) { return self.renderer().progress(); }, "0 ... 1")
      .def_property_readonly(
          "estimated_error", [](PythonRender& self) { return self.renderer().estimated_error(); },
          "99th percentile of the error estimates of the pixels finished so far, display units, at most 1/32 "
          "of "
          "it too large; 0 before the first. Finished are those that wait() has told of, or will next.")
      .def("read", &PythonRender::read, py::arg("name"), py::arg("x"), py::arg("y"), py::arg("width"),
           py::arg("height"),
           "A block of a pass: (height * width, channels) float32, bottom row first, a copy.")
      .def(
          "view",
          [](const py::object& self, const std::string& name) {
            return self.cast<const PythonRender&>().view(self, name);
          },
          py::arg("name"),
          "A whole pass in the renderer's own memory: (height * width, channels) float32, bottom row first, "
          "read "
          "only. Call it after finish(), as pixels that are being written are not whole.")
      .def("passes", &PythonRender::passes,
           "All passes: name -> (height, width, channels) float32, bottom row first.")
      .def("statistics", &PythonRender::statistics, "What was done and what it took; of a finished render.");
}

}  // namespace penumbra::python
