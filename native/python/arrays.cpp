// SPDX-License-Identifier: GPL-3.0-or-later
#include "python/arrays.h"

#include <cstring>
#include <limits>

namespace penumbra::python {
namespace {

std::string shape_text(const std::vector<py::ssize_t>& shape) {
  std::string text;
  for (py::ssize_t n : shape) {
    if (!text.empty()) text.append(", ");
    text.append(n == kAny ? std::string("any") : std::to_string(n));
  }
  return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

std::string type_text(const py::array& array) {
  return py::str(array.dtype()).cast<std::string>();
}

void check_kind(const py::array& array, const std::string& kinds, const char* expected,
                const std::string& name, const char* argument) {
  if (kinds.find(array.dtype().kind()) == std::string::npos)
    throw py::value_error(name + ": " + argument + " has type " + type_text(array) + ", expected " +
                          expected);
}

/// Same values, C order, type T; no copy where it is that already.
template <typename T>
py::array_t<T, py::array::c_style | py::array::forcecast> contiguous(const py::array& array) {
  return py::array_t<T, py::array::c_style | py::array::forcecast>(array);
}

std::vector<Vec3f> read_vectors(const py::array& array, size_t count) {
  const auto values = contiguous<float>(array);
  std::vector<Vec3f> result(count);
  if (count) std::memcpy(static_cast<void*>(result.data()), values.data(), count * sizeof(Vec3f));
  return result;
}

}  // namespace

void check_shape(const py::array& array, const std::vector<py::ssize_t>& shape, const std::string& name,
                 const char* argument) {
  bool matches = size_t(array.ndim()) == shape.size();
  for (size_t i = 0; matches && i < shape.size(); ++i)
    matches = shape[i] == kAny || array.shape(py::ssize_t(i)) == shape[i];
  if (matches) return;
  const std::vector<py::ssize_t> given(array.shape(), array.shape() + array.ndim());
  throw py::value_error(name + ": " + argument + " has shape " + shape_text(given) + ", expected " +
                        shape_text(shape));
}

std::vector<Vec3d> read_positions(const py::array& array, const std::string& name) {
  check_shape(array, {kAny, 3}, name, "positions");
  check_kind(array, "f", "a floating point type", name, "positions");
  std::vector<Vec3d> result(size_t(array.shape(0)));
  const auto convert = [&](const auto& values) {
    const auto* p = values.data();
    for (Vec3d& v : result) {
      v = {double(p[0]), double(p[1]), double(p[2])};
      p += 3;
    }
  };
  // Blender's own float32 is read in place; everything else goes through double.
  if (array.itemsize() == sizeof(float))
    convert(contiguous<float>(array));
  else
    convert(contiguous<double>(array));
  return result;
}

std::vector<std::array<uint32_t, 3>> read_triangles(const py::array& array, const std::string& name) {
  check_shape(array, {kAny, 3}, name, "triangles");
  check_kind(array, "iu", "an integer type", name, "triangles");
  std::vector<std::array<uint32_t, 3>> result(size_t(array.shape(0)));
  const size_t count = 3 * result.size();
  uint32_t* out = result.empty() ? nullptr : result.front().data();
  if (array.itemsize() == sizeof(uint32_t)) {
    // A negative index becomes one beyond every mesh, which the scene refuses.
    const auto values = contiguous<uint32_t>(array);
    if (count) std::memcpy(out, values.data(), count * sizeof(uint32_t));
  } else {
    const auto values = contiguous<int64_t>(array);
    for (size_t i = 0; i < count; ++i) {
      const int64_t index = values.data()[i];
      if (index < 0 || index > std::numeric_limits<uint32_t>::max())
        throw py::value_error(name + ": triangle " + std::to_string(i / 3) + " names vertex " +
                              std::to_string(index));
      out[i] = uint32_t(index);
    }
  }
  return result;
}

std::vector<Vec3f> read_corner_normals(const py::array& array, const std::string& name) {
  check_kind(array, "f", "a floating point type", name, "corner_normals");
  return read_vectors(array, size_t(array.size()) / 3);
}

bool are_normals_of_vertices(const py::array& array, size_t vertices) {
  return array.ndim() == 2 && size_t(array.shape(0)) == vertices && array.shape(1) == 3;
}

std::vector<Vec3f> read_colors(const py::array& array, const std::string& name, const char* argument) {
  check_shape(array, {kAny, kAny, 3}, name, argument);
  check_kind(array, "f", "a floating point type", name, argument);
  return read_vectors(array, size_t(array.shape(0)) * size_t(array.shape(1)));
}

std::vector<std::array<float, 4>> read_attribute(const py::array& array, const std::string& name) {
  check_shape(array, {kAny, 3, 4}, name, "attributes");
  check_kind(array, "f", "a floating point type", name, "attributes");
  const auto values = contiguous<float>(array);
  std::vector<std::array<float, 4>> result(size_t(array.shape(0)) * 3);
  if (!result.empty()) std::memcpy(result.data(), values.data(), result.size() * sizeof(result[0]));
  return result;
}

std::vector<float> read_floats(const py::array& array, const std::string& name, const char* argument) {
  check_shape(array, {kAny}, name, argument);
  check_kind(array, "f", "a floating point type", name, argument);
  const auto values = contiguous<float>(array);
  return {values.data(), values.data() + values.size()};
}

std::vector<uint32_t> read_counts(const py::array& array, const std::string& name) {
  check_shape(array, {kAny}, name, "counts");
  check_kind(array, "iu", "an integer type", name, "counts");
  const auto values = contiguous<int64_t>(array);
  std::vector<uint32_t> result;
  for (py::ssize_t i = 0; i < values.size(); ++i) {
    const int64_t count = values.data()[i];
    if (count < 0 || count > int64_t(std::numeric_limits<uint32_t>::max()))
      throw py::value_error(name + ": counts must lie in 0 ... 2^32 - 1");
    result.push_back(uint32_t(count));
  }
  return result;
}

std::vector<uint32_t> read_slots(const py::array& array, const std::string& name) {
  check_shape(array, {kAny}, name, "material_slots");
  check_kind(array, "iu", "an integer type", name, "material_slots");
  std::vector<uint32_t> result(size_t(array.shape(0)));
  const auto convert = [&](const auto& values) {
    for (size_t i = 0; i < result.size(); ++i)
      result[i] = uint32_t(std::clamp<int64_t>(values.data()[i], 0, std::numeric_limits<uint32_t>::max()));
  };
  if (array.dtype().kind() == 'i' && array.itemsize() == sizeof(int32_t))
    convert(contiguous<int32_t>(array));
  else
    convert(contiguous<int64_t>(array));
  // The same for all: as none.
  if (std::all_of(result.begin(), result.end(), [](uint32_t slot) { return slot == 0; })) result.clear();
  return result;
}

Affine read_transform(const py::array& array, const std::string& name, const char* argument) {
  check_shape(array, {4, 4}, name, argument);
  check_kind(array, "f", "a floating point type", name, argument);
  const auto values = contiguous<double>(array);
  const auto m = values.unchecked<2>();
  if (m(3, 0) != 0 || m(3, 1) != 0 || m(3, 2) != 0 || m(3, 3) != 1)
    throw py::value_error(name + ": " + argument + " is not affine, its last row is not 0, 0, 0, 1");
  const auto column = [&](py::ssize_t i) { return Vec3d{m(0, i), m(1, i), m(2, i)}; };
  return {column(0), column(1), column(2), column(3)};
}

py::array_t<float> copy_block(std::span<const float> pass, size_t pass_width, size_t channels, size_t x,
                              size_t y, size_t width, size_t height) {
  py::array_t<float> result({py::ssize_t(height * width), py::ssize_t(channels)});
  float* out = result.mutable_data();
  for (size_t row = 0; row < height; ++row)
    std::memcpy(out + row * width * channels, pass.data() + ((y + row) * pass_width + x) * channels,
                width * channels * sizeof(float));
  return result;
}

}  // namespace penumbra::python
