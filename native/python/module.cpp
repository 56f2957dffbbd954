// SPDX-License-Identifier: GPL-3.0-or-later
// The module penumbra_native: the renderer for Python, with or without Blender.
#include "math/simd.h"
#include "python/bindings.h"
#include "visibility/embree.h"

PYBIND11_MODULE(penumbra_native, module) {
  namespace python = penumbra::python;
  // A module that loads beside the wrong Embree would render black without a word; refuse to load instead.
  try {
    penumbra::embree::self_test();
  } catch (const std::exception& error) {
    throw pybind11::import_error(error.what());
  }
  module.doc() = "Penumbra: direct light from luminaires with soft shadows, to a stated error.";
  module.attr("__version__") = python::kVersion;
  module.attr("build") = PENUMBRA_BUILD;
  module.attr("isa") = penumbra::vector_isa();
  module.attr("embree") = penumbra::embree::version();
  module.def(
      "self_test", &penumbra::embree::self_test,
      "Raises RuntimeError with a sentence if the loaded Embree is not the one this module was built for.");
  python::bind_arrays(module);
  python::bind_scene(module);
  python::bind_render(module);
  python::bind_sampling(module);
}
