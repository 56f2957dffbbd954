// SPDX-License-Identifier: GPL-3.0-or-later
// What is made of a mesh's arrays before they go into a scene, in one pass each: rows picked out, as NumPy's
// values[indices], from any strides, and normals of vertices.
#include <cstring>

#include "python/arrays.h"
#include "python/bindings.h"
#include "scene/vertex_normals.h"

namespace penumbra::python {
namespace {

constexpr py::ssize_t kItem = 4;  // bytes; of float32 and 32-bit integers

/// Throws ValueError or IndexError that says what does not fit.
py::array gather(const py::array& values, const py::array& indices) {
  const auto refuse = [](const std::string& text) { throw py::value_error("gather: " + text); };
  if (values.itemsize() != kItem || indices.itemsize() != kItem)
    refuse("values and indices must have four bytes an element");
  const char kind = indices.dtype().kind();
  if (kind != 'i' && kind != 'u') refuse("indices must be integers");
  if (values.ndim() < 1 || values.ndim() > 2 || indices.ndim() < 1 || indices.ndim() > 2)
    refuse("values and indices must have one or two dimensions");
  const py::ssize_t components = values.ndim() == 2 ? values.shape(1) : 1;
  const py::ssize_t columns = indices.ndim() == 2 ? indices.shape(1) : 1;
  std::vector<py::ssize_t> shape(indices.shape(), indices.shape() + indices.ndim());
  if (values.ndim() == 2) shape.push_back(components);
  py::array result(values.dtype(), shape);

  const auto* source = static_cast<const char*>(values.data());
  const auto* index = static_cast<const char*>(indices.data());
  auto* out = static_cast<char*>(result.mutable_data());
  const uint32_t count = uint32_t(std::min<py::ssize_t>(values.shape(0), INT32_MAX));
  const py::ssize_t row_stride = values.strides(0), column_stride = components > 1 ? values.strides(1) : 0;
  const py::ssize_t index_stride = indices.strides(0), next_index = columns > 1 ? indices.strides(1) : 0;
  for (py::ssize_t row = 0; row < indices.shape(0); ++row)
    for (py::ssize_t column = 0; column < columns; ++column) {
      uint32_t i;  // a negative index becomes one beyond the end
      std::memcpy(&i, index + row * index_stride + column * next_index, kItem);
      if (i >= count)
        throw py::index_error("gather: index " + std::to_string(int32_t(i)) + " in " + std::to_string(count));
      const char* from = source + py::ssize_t(i) * row_stride;
      for (py::ssize_t k = 0; k < components; ++k, out += kItem)
        std::memcpy(out, from + k * column_stride, kItem);
    }
  return result;
}

template <typename T>
using Rows = py::array_t<T, py::array::c_style | py::array::forcecast>;

template <typename T>
std::span<const T> numbers(const Rows<T>& array, const char* argument) {
  check_shape(array, {kAny}, "vertex_normals", argument);
  return {array.data(), size_t(array.size())};
}

std::span<const Vec3f> vectors(const Rows<float>& array, const char* argument) {
  check_shape(array, {kAny, 3}, "vertex_normals", argument);
  return {reinterpret_cast<const Vec3f*>(array.data()), size_t(array.shape(0))};
}

Rows<float> vertex_normals_of(const Rows<float>& positions, const Rows<int32_t>& corner_vertices,
                              const Rows<int32_t>& starts, const Rows<int32_t>& totals,
                              const Rows<float>& polygon_normals) {
  const std::vector<Vec3f> normals =
      vertex_normals(vectors(positions, "positions"), {numbers(starts, "starts"), numbers(totals, "totals"),
                                                       numbers(corner_vertices, "corner_vertices"),
                                                       vectors(polygon_normals, "polygon_normals")});
  Rows<float> result({py::ssize_t(normals.size()), py::ssize_t(3)});
  if (!normals.empty()) std::memcpy(result.mutable_data(), normals.data(), normals.size() * sizeof(Vec3f));
  return result;
}

}  // namespace

void bind_arrays(py::module_& module) {
  module.def("gather", &gather, py::arg("values"), py::arg("indices"),
             R"(values[indices] as a new array, its shape that of indices and of a value.

values: (N,) or (N, K), float32 or 32-bit integers; indices: (M,) or (M, L), 32-bit integers; both with any strides.
IndexError for an index beyond the end.)");
  module.def(
      "vertex_normals", &vertex_normals_of, py::arg("positions"), py::arg("corner_vertices"),
      py::arg("starts"), py::arg("totals"), py::arg("polygon_normals"),
      R"((V, 3) float32, the unit normal of each vertex: its polygons' normals weighted by their angles there.

Added up in the order of the corners: the same bits each time.
positions: (V, 3); corner_vertices: (C,) the vertex of each corner; starts, totals: (P,) the first corner of each
polygon and how many it has; polygon_normals: (P, 3), unit length. IndexError for a vertex or corner that is not there.)");
}

}  // namespace penumbra::python
