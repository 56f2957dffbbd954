// SPDX-License-Identifier: GPL-3.0-or-later
// Three-component vectors: double where scenes are placed, float where rays are traced.
#pragma once

#include <algorithm>
#include <cmath>

namespace penumbra {

template <typename T>
struct Vec3 {
  T x{}, y{}, z{};

  constexpr Vec3() = default;
  constexpr Vec3(T x_, T y_, T z_) : x(x_), y(y_), z(z_) {}
  template <typename S>
  constexpr explicit Vec3(const Vec3<S>& o) : x(T(o.x)), y(T(o.y)), z(T(o.z)) {}

  constexpr T operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  constexpr Vec3 operator-() const { return {-x, -y, -z}; }
  constexpr Vec3& operator+=(const Vec3& o) { return *this = *this + o; }

  friend constexpr Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator*(const Vec3& a, const Vec3& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend constexpr Vec3 operator*(const Vec3& a, T s) { return {a.x * s, a.y * s, a.z * s}; }
  friend constexpr Vec3 operator*(T s, const Vec3& a) { return a * s; }
  friend constexpr Vec3 operator/(const Vec3& a, T s) { return {a.x / s, a.y / s, a.z / s}; }
  friend constexpr bool operator==(const Vec3& a, const Vec3& b) = default;
};

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

template <typename T>
constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <typename T>
constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <typename T>
T length(const Vec3<T>& a) {
  return std::sqrt(dot(a, a));
}

/// The unit vector along a; the zero vector where a is zero.
template <typename T>
Vec3<T> normalize(const Vec3<T>& a) {
  const T l = length(a);
  return l > T(0) ? a / l : Vec3<T>{};
}

/// Mirror direction of d at a surface with unit normal n.
template <typename T>
constexpr Vec3<T> reflect(const Vec3<T>& d, const Vec3<T>& n) {
  return d - n * (T(2) * dot(d, n));
}

template <typename T>
constexpr T max_component(const Vec3<T>& a) {
  return std::max({a.x, a.y, a.z});
}

/// Largest absolute coordinate: the size that float rounding is relative to.
template <typename T>
T max_abs(const Vec3<T>& a) {
  return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
}

template <typename T>
Vec3<T> absolute(const Vec3<T>& a) {
  return {std::abs(a.x), std::abs(a.y), std::abs(a.z)};
}

template <typename T>
bool is_finite(const Vec3<T>& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

}  // namespace penumbra
