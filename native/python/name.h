// SPDX-License-Identifier: GPL-3.0-or-later
// Names at the boundary.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace penumbra::python {

/// Of an object, a material, a luminaire, an image. One with a zero character is refused: messages, which
/// begin with names, would end there.
struct Name : std::string {};

}  // namespace penumbra::python

template <>
struct pybind11::detail::type_caster<penumbra::python::Name> {
  PYBIND11_TYPE_CASTER(penumbra::python::Name, const_name("str"));

  bool load(handle source, bool convert) {
    make_caster<std::string> text;
    if (!text.load(source, convert)) return false;
    value.assign(cast_op<std::string&>(text));
    if (value.find('\0') != std::string::npos) throw value_error("name: a zero character in it");
    return true;
  }
};
