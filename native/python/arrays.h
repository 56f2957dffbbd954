// SPDX-License-Identifier: GPL-3.0-or-later
// NumPy arrays at the boundary: shapes and types are checked, with the argument's name in every error.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <span>
#include <string>
#include <vector>

#include "math/transform.h"

namespace penumbra::python {

namespace py = pybind11;

/// A shape for check_shape: kAny stands for any length.
inline constexpr py::ssize_t kAny = -1;

/// Throws ValueError "NAME: ARGUMENT has shape (...), expected (...)".
void check_shape(const py::array& array, const std::vector<py::ssize_t>& shape, const std::string& name,
                 const char* argument);

/// (V, 3) floating point, any strides.
std::vector<Vec3d> read_positions(const py::array& array, const std::string& name);
/// (T, 3) integers that fit into 32 bits without a sign.
std::vector<std::array<uint32_t, 3>> read_triangles(const py::array& array, const std::string& name);
/// (N,) floating point.
std::vector<float> read_floats(const py::array& array, const std::string& name, const char* argument);
/// (N,) integers from 0 on that fit into 32 bits.
std::vector<uint32_t> read_counts(const py::array& array, const std::string& name);
/// (T, 3, 3) floating point, one normal a corner.
std::vector<Vec3f> read_corner_normals(const py::array& array, const std::string& name);
/// (V, 3): one at each of so many vertices.
bool are_normals_of_vertices(const py::array& array, size_t vertices);
/// (height, width, 3) colours, row by row.
std::vector<Vec3f> read_colors(const py::array& array, const std::string& name, const char* argument);
/// (T, 3, 4) floating point, four values a corner.
std::vector<std::array<float, 4>> read_attribute(const py::array& array, const std::string& name);
/// (T,) integers; negative ones count as slot 0, as in Blender.
std::vector<uint32_t> read_slots(const py::array& array, const std::string& name);
/// (4, 4) floating point whose last row is 0, 0, 0, 1.
Affine read_transform(const py::array& array, const std::string& name, const char* argument);

/// Copies rows x channels floats into a new array.
py::array_t<float> copy_block(std::span<const float> pass, size_t pass_width, size_t channels, size_t x,
                              size_t y, size_t width, size_t height);

}  // namespace penumbra::python
