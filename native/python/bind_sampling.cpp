// SPDX-License-Identifier: GPL-3.0-or-later
// penumbra_native.sample_points: the very points that rendering uses, for figures and tests.
#include <pybind11/stl.h>

#include <algorithm>

#include "python/arrays.h"
#include "python/bindings.h"
#include "sampling/hash.h"

namespace penumbra::python {
namespace {

py::array_t<double> sample_points(const std::string& sampler, uint32_t count, const std::string& sample_reuse,
                                  int64_t seed, uint64_t pixel, std::optional<uint32_t> samples_per_pixel) {
  if (count > (1u << 24)) throw py::value_error("count must be at most 2^24");
  const uint32_t per_pixel = samples_per_pixel.value_or(std::max(count, 1u));
  const auto source = make_sampler({sampler_from_name(sampler), reuse_from_name(sample_reuse), uint32_t(seed),
                                    std::max(per_pixel, count)});
  py::array_t<double> result({py::ssize_t(count), py::ssize_t(2)});
  auto out = result.mutable_unchecked<2>();
  alignas(64) float u[kPacket], v[kPacket];
  for (uint32_t first = 0; first < count; first += kPacket) {
    source->points({pixel, hash_of(pixel)}, first, kPacket, u, v);
    for (uint32_t i = 0; i < std::min(kPacket, count - first); ++i) {
      out(first + i, 0) = u[i];
      out(first + i, 1) = v[i];
    }
  }
  return result;
}

}  // namespace

void bind_sampling(py::module_& module) {
  module.def(
      "sample_points", &sample_points, py::arg("sampler"), py::arg("count"), py::arg("sample_reuse") = "SAME",
      py::arg("seed") = 0, py::arg("pixel") = 0, py::arg("samples_per_pixel") = py::none(),
      R"(The first `count` points that a pixel's only luminaire gets: (count, 2) float64 in [0, 1), multiples of 2^-24.

samples_per_pixel: how far CONTINUED and PRS move on from pixel to pixel (default: count).)");
}

}  // namespace penumbra::python
