// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers and arrays out of a fuzzer's bytes; zeros once they are used up.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <type_traits>

#include "math/transform.h"

namespace penumbra::fuzz {

class Bytes {
 public:
  Bytes(const uint8_t* data, size_t size) : data_(data), size_(size) {}

  uint8_t byte() {
    if (size_ == 0) return 0;
    --size_;
    return *data_++;
  }
  bool flag() { return byte() & 1; }
  /// 0 ... most - 1
  uint32_t below(uint32_t most) { return byte() % most; }

  /// Mostly a plain number in -4 ... 4, with steps that make things meet; else an extreme one, or any bits at
  /// all.
  double number() {
    const uint8_t kind = byte();
    if (kind < 200) return (kind - 100) / 25.0;
    if (kind < 240) {
      const double special[] = {0.0,  -0.0,   1e-300, 1e300,    -1e300,    1e-30, 1e30, 1e-6,
                                -1e6, 5e-324, 1e7,    INFINITY, -INFINITY, NAN,   1e-9, 16777217.0};
      return special[byte() % std::size(special)];
    }
    return bits<double>();
  }
  Vec3d vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  /// Mostly in 0 ... 1.
  double share() {
    const uint8_t kind = byte();
    return kind < 250 ? kind / 249.0 : number();
  }
  Vec3d colour() {
    const double r = share(), g = share(), b = share();
    return {r, g, b};
  }
  Affine transform() {
    switch (byte() % 4) {
      case 0:
        return {};
      case 1: {
        Affine moved;
        moved.origin = vector();
        return moved;
      }
      case 2: {
        const double s = number();
        return {{s, 0, 0}, {0, s, 0}, {0, 0, s}, vector()};
      }
      default: {
        Affine any;
        any.x_axis = vector(), any.y_axis = vector(), any.z_axis = vector(), any.origin = vector();
        return any;
      }
    }
  }

  template <typename T>
  T bits() {
    std::conditional_t<sizeof(T) == 8, uint64_t, uint32_t> raw = 0;
    for (size_t i = 0; i < sizeof(T); ++i) raw = raw << 8 | byte();
    return std::bit_cast<T>(raw);
  }

 private:
  const uint8_t* data_;
  size_t size_;
};

}  // namespace penumbra::fuzz
