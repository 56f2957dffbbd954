// SPDX-License-Identifier: GPL-3.0-or-later
// Materials with programs, and images: what penumbra_native.Scene takes of them.
#include <pybind11/stl.h>

#include "material/evaluate.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/name.h"

namespace penumbra::python {
namespace {

using PythonOperation = std::tuple<std::string, int, std::vector<int>, int, int>;
using PythonClosure = std::tuple<std::string, int, int, int, int>;
using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// Registers are numbered with 16 bits.
constexpr size_t kMaxRegisters = 65536;

class ProgramReader {
 public:
  ProgramReader(const std::string& name, const FloatArray& registers, const FloatArray& tables, size_t images)
      : name_(name), images_(images) {
    check_shape(registers, {kAny, 3}, name, "registers");
    check_shape(tables, {kAny}, name, "tables");
    const auto count = size_t(registers.shape(0));
    if (count < 1 || count > kMaxRegisters) throw py::value_error(name + ": too many nodes for one material");
    const auto r = registers.unchecked<2>();
    for (py::ssize_t i = 0; i < registers.shape(0); ++i)
      program_.registers.emplace_back(r(i, 0), r(i, 1), r(i, 2));
    program_.tables.assign(tables.data(), tables.data() + tables.size());
  }

  void add(const PythonOperation& given) {
    const auto& [operation_name, out, in, shift, data] = given;
    const NamedOperation* named = find_operation(operation_name);
    if (!named) throw py::value_error(name_ + ": there is no operation '" + operation_name + "'");
    Operation operation{named->function, {}, register_number(out), uint16_t(shift), data};
    register_number(out + 1);
    if (in.size() > Operation::kMaxInputs || shift < 0 || shift > 2)
      throw py::value_error(name_ + ": operation '" + operation_name + "' has impossible inputs");
    if (!named->fits(data, program_.tables, images_))
      throw py::value_error(name_ + ": operation '" + operation_name +
                            "' reads beyond the tables or images: " + std::to_string(data));
    for (size_t i = 0; i < in.size(); ++i) operation.in[i] = register_number(in[i]);
    program_.operations.push_back(operation);
  }

  void add(const PythonClosure& given) {
    static const std::map<std::string, ClosureKind> kinds{
        {"diffuse", ClosureKind::kDiffuse},
        {"disney", ClosureKind::kDisney},
        {"sheen", ClosureKind::kSheen},
        {"glossy", ClosureKind::kGlossy},
        {"correlated glossy", ClosureKind::kCorrelatedGlossy},
        {"beckmann", ClosureKind::kBeckmann},
        {"clearcoat", ClosureKind::kClearcoat},
        {"phong", ClosureKind::kPhong},
        {"emission", ClosureKind::kEmission},
        {"transparent", ClosureKind::kTransparent},
        {"holdout", ClosureKind::kHoldout}};
    const auto& [kind, colour, edge, ior, roughness] = given;
    const auto found = kinds.find(kind);
    if (found == kinds.end()) throw py::value_error(name_ + ": there is no closure '" + kind + "'");
    program_.closures.push_back({found->second, register_number(colour), register_number(edge),
                                 register_number(ior), register_number(roughness)});
  }

  Program finish(int normal) {
    program_.normal = register_number(normal);
    fold(program_);
    return std::move(program_);
  }

 private:
  uint16_t register_number(int number) const {
    if (number < 0 || size_t(number) >= program_.registers.size())
      throw py::value_error(name_ + ": there is no register " + std::to_string(number));
    return uint16_t(number);
  }

  std::string name_;
  size_t images_;
  Program program_;
};

Program read_program(const std::string& name, const FloatArray& registers,
                     const std::vector<PythonOperation>& operations, const FloatArray& tables,
                     const std::vector<PythonClosure>& closures, int normal, size_t images) {
  ProgramReader reader(name, registers, tables, images);
  for (const auto& operation : operations) reader.add(operation);
  for (const auto& closure : closures) reader.add(closure);
  return reader.finish(normal);
}

using MaybeColor = std::optional<std::array<double, 3>>;

/// What a program emits; none where that varies.
MaybeColor emission_of_program(const Name& name, const FloatArray& registers,
                               const std::vector<PythonOperation>& operations, const FloatArray& tables,
                               const std::vector<PythonClosure>& closures, int normal) {
  const Program emission =
      part_of(read_program(name, registers, operations, tables, closures, normal, 0), ClosureKind::kEmission);
  if (!emission.operations.empty()) return std::nullopt;
  const Vec3d e = constant_closures(emission).emission;
  return std::array<double, 3>{e.x, e.y, e.z};
}

uint32_t add_program(PythonScene& self, const Name& name, const FloatArray& registers,
                     const std::vector<PythonOperation>& operations, const FloatArray& tables,
                     const std::vector<PythonClosure>& closures, int normal, bool grey_transparency,
                     bool facet_bumps) {
  Program program =
      read_program(name, registers, operations, tables, closures, normal, self.scene->images().size());
  program.grey_transparency = grey_transparency;
  program.facet_bumps = facet_bumps;
  Material material;
  if (is_constant(program)) {
    static_cast<Closures&>(material) = constant_closures(program);
  } else {
    if (program.has(ClosureKind::kTransparent))
      material.shadow_program = std::make_shared<const Program>(part_of(program, ClosureKind::kTransparent));
    Program emission = part_of(program, ClosureKind::kEmission);
    if (emission.operations.empty())
      material.emission = constant_closures(emission).emission;
    else
      material.emission_program = std::make_shared<const Program>(std::move(emission));
    material.program = std::make_shared<const Program>(std::move(program));
  }
  material.name = name;
  return self.scene->add_shader(std::move(material));
}

template <typename T>
T choice(const std::string& value, const std::string& name, const std::map<std::string, T>& choices) {
  const auto found = choices.find(value);
  if (found == choices.end()) throw py::value_error(name + ": '" + value + "' is unknown");
  return found->second;
}

uint32_t add_image(PythonScene& self, const Name& name,
                   const std::vector<std::tuple<uint32_t, std::string, std::optional<py::bytes>>>& files,
                   bool tiled, const std::string& wrap, const std::string& interpolation, bool srgb,
                   const std::string& alpha) {
  Image image;
  image.name = name;
  for (const auto& [tile, path, bytes] : files)
    image.files.push_back(
        {tile, path, bytes ? std::make_shared<const std::string>(std::string(*bytes)) : nullptr});
  image.tiled = tiled;
  image.wrap = choice<ImageWrap>(wrap, name,
                                 {{"REPEAT", ImageWrap::kRepeat},
                                  {"MIRROR", ImageWrap::kMirror},
                                  {"EXTEND", ImageWrap::kExtend},
                                  {"CLIP", ImageWrap::kClip}});
  image.interpolation = choice<ImageInterpolation>(interpolation, name,
                                                   {{"Linear", ImageInterpolation::kLinear},
                                                    {"Closest", ImageInterpolation::kClosest},
                                                    {"Cubic", ImageInterpolation::kCubic}});
  image.srgb = srgb;
  image.alpha = choice<ImageAlpha>(alpha, name,
                                   {{"COVERAGE", ImageAlpha::kCoverage},
                                    {"STRAIGHT", ImageAlpha::kStraight},
                                    {"CHANNEL", ImageAlpha::kChannel},
                                    {"NONE", ImageAlpha::kNone}});
  return self.scene->add_image(std::move(image));
}

py::bytes encode(const FloatArray& pixels) {
  check_shape(pixels, {kAny, kAny, kAny}, "pixels", "pixels");
  if (pixels.size() == 0) throw py::value_error("pixels: there are none");
  return encode_image(uint32_t(pixels.shape(1)), uint32_t(pixels.shape(0)), uint32_t(pixels.shape(2)),
                      pixels.data());
}

}  // namespace

void bind_material(py::module_& module, py::class_<PythonScene>& scene) {
  module.attr("MAX_LOBES") = Closures::kMaxLobes;
  module.def("operations", &operation_names, "Names of the operations that Scene.add_program knows.");
  module.def("emission_of_program", &emission_of_program, py::arg("name"), py::arg("registers"),
             py::arg("operations"), py::arg("tables"), py::arg("closures"), py::arg("normal") = 0,
             "What a program emits (r, g, b), None where it varies. Arguments as of Scene.add_program.");
  module.def("encode_image", &encode, py::arg("pixels"),
             "(height, width, channels) float32, bottom row first, as the bytes of an OpenEXR file.");
  scene
      .def("add_program", &add_program, py::arg("name"), py::arg("registers"), py::arg("operations"),
           py::arg("tables"), py::arg("closures"), py::arg("normal") = 0,
           py::arg("grey_transparency") = false, py::arg("facet_bumps") = false,
           R"(Adds a material that is computed at each surface point; returns its number.

registers: (R, 3) float32, the initial values; number 0 is zero. operations: (name, out, inputs, shift, data), each writing
the registers out and out + 1. closures: (kind, colour, edge, ior, roughness), numbers of registers. normal: register of the
shading normal, 0 for the surface's own. grey_transparency: what goes through is the same for red, green and blue, so that
its shadows need not be traced for each of them. facet_bumps: diffuse light fades on bumps as Conty et al. 2019 have it, not
Chiang et al. 2019. What does not vary is computed here, once.)")
      .def(
          "emission_of",
          [](const PythonScene& self, uint32_t material) -> MaybeColor {
            const auto& materials = self.scene->materials();
            if (material >= materials.size())
              throw py::value_error("there is no material with number " + std::to_string(material));
            if (materials[material].emission_program) return std::nullopt;
            const Vec3d& e = materials[material].emission;
            return std::array<double, 3>{e.x, e.y, e.z};
          },
          py::arg("material"),
          "Radiance (r, g, b) that a material's surface sends out on both sides; None where it varies.")
      .def("add_image", &add_image, py::arg("name"), py::arg("files"), py::arg("tiled") = false,
           py::arg("wrap") = "REPEAT", py::arg("interpolation") = "Linear", py::arg("srgb") = false,
           py::arg("alpha") = "COVERAGE",
           R"(Adds an image for programs to look up; returns its number.

files: (UDIM tile, path, bytes of the file or None to read it from the path). wrap: REPEAT, MIRROR, EXTEND or CLIP.
interpolation: Linear, Closest or Cubic. alpha, the fourth channel: COVERAGE in the colours, STRAIGHT colours
beside it, a CHANNEL like others, or NONE. A file that cannot be read is magenta, and a warning of the render's statistics.)");
}

}  // namespace penumbra::python
