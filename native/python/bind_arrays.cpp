// SPDX-License-Identifier: GPL-3.0-or-later
// Picking rows out of arrays, as NumPy's values[indices], but in one pass and from any strides.
#include <cstring>

#include "python/arrays.h"
#include "python/bindings.h"

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

}  // namespace

void bind_arrays(py::module_& module) {
  module.def("gather", &gather, py::arg("values"), py::arg("indices"),
             R"(values[indices] as a new array, its shape that of indices and of a value.

values: (N,) or (N, K), float32 or 32-bit integers; indices: (M,) or (M, L), 32-bit integers; both with any strides.
IndexError for an index beyond the end.)");
}

}  // namespace penumbra::python
