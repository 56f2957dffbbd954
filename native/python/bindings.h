// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of the module `penumbra_native`, and the names of enumerations on its Python side.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "material/evaluate.h"
#include "render/settings.h"
#include "visibility/geometry.h"

namespace penumbra::python {

inline constexpr const char* kVersion = PENUMBRA_VERSION;

/// A scene together with its acceleration structure, built for the first render and used by all.
struct PythonScene {
  std::shared_ptr<Scene> scene = std::make_shared<Scene>();
  std::shared_ptr<const Materials> materials;
  std::shared_ptr<const Geometry> geometry;
  std::shared_ptr<TextureStore> texture_store;  // may be none
  double build_seconds = 0;

  /// memory_limit: bytes, 0: none.
  void build(uint64_t memory_limit);
};

/// Each throws ValueError that gives the setting's name, the value and what is allowed.
SamplerKind sampler_from_name(const std::string& name);
SampleReuse reuse_from_name(const std::string& name);
StopRuleKind stop_rule_from_name(const std::string& name);
FilterKind filter_from_name(const std::string& name);

void bind_arrays(pybind11::module_& module);
void bind_scene(pybind11::module_& module);
void bind_luminaires(pybind11::module_& module, pybind11::class_<PythonScene>& scene);
void bind_material(pybind11::module_& module, pybind11::class_<PythonScene>& scene);
void bind_render(pybind11::module_& module);
void bind_sampling(pybind11::module_& module);

}  // namespace penumbra::python
