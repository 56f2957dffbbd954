// SPDX-License-Identifier: GPL-3.0-or-later
// Operations on vectors: the Vector Math, Mapping, Separate and Combine XYZ nodes, and matrices.
#include <cmath>

#include "material/machine.h"

namespace penumbra {
namespace {

template <auto F>
Vec3f each(const Vec3f& a, const Vec3f& b = {}, const Vec3f& c = {}) {
  return {F(a.x, b.x, c.x), F(a.y, b.y, c.y), F(a.z, b.z, c.z)};
}

/// An operation on each component of three vectors by itself.
template <auto F>
void by_component(Machine& m, const Operation& o) {
  m.set(o, each<F>(m.in(o, 0), m.in(o, 1), m.in(o, 2)));
}

/// An operation that makes a vector, or a number, of three vectors.
template <auto F>
void vector(Machine& m, const Operation& o) {
  m.set(o, F(m.in(o, 0), m.in(o, 1), m.in(o, 2)));
}

constexpr auto kDivide = [](float a, float b, float) { return b != 0 ? a / b : 0.0f; };

float wrap(float value, float high, float low) {
  const float range = high - low;
  return range != 0 ? value - range * std::floor((value - low) / range) : low;
}

Vec3f project(const Vec3f& a, const Vec3f& b) {
  const float bb = dot(b, b);
  return bb != 0 ? b * (dot(a, b) / bb) : Vec3f{};
}

void refract(Machine& m, const Operation& o) {
  const Vec3f &i = m.in(o, 0), n = normalize(m.in(o, 1));
  const float eta = m.number(o, 3), c = dot(n, i), k = 1 - eta * eta * (1 - c * c);
  m.set(o, k < 0 ? Vec3f{} : i * eta - n * (eta * c + std::sqrt(k)));
}

/// Columns of the rotation by Euler angles in the order XYZ.
struct Rotation {
  Vec3f x, y, z;
  explicit Rotation(const Vec3f& e) {
    const float cx = std::cos(e.x), cy = std::cos(e.y), cz = std::cos(e.z), sx = std::sin(e.x),
                sy = std::sin(e.y), sz = std::sin(e.z);
    x = {cy * cz, cy * sz, -sy};
    y = {sy * sx * cz - cx * sz, sy * sx * sz + cx * cz, cy * sx};
    z = {sy * cx * cz + sx * sz, sy * cx * sz - sx * cz, cy * cx};
  }
  Vec3f apply(const Vec3f& v) const { return x * v.x + y * v.y + z * v.z; }
  Vec3f inverse(const Vec3f& v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
};

/// Inputs of the Mapping node: vector, location, rotation, scale.
void mapping_point(Machine& m, const Operation& o) {
  m.set(o, Rotation(m.in(o, 2)).apply(m.in(o, 0) * m.in(o, 3)) + m.in(o, 1));
}
void mapping_vector(Machine& m, const Operation& o) {
  m.set(o, Rotation(m.in(o, 2)).apply(m.in(o, 0) * m.in(o, 3)));
}
void mapping_texture(Machine& m, const Operation& o) {
  m.set(o, each<kDivide>(Rotation(m.in(o, 2)).inverse(m.in(o, 0) - m.in(o, 1)), m.in(o, 3)));
}
void mapping_normal(Machine& m, const Operation& o) {
  m.set(o, normalize(Rotation(m.in(o, 2)).apply(each<kDivide>(m.in(o, 0), m.in(o, 3)))));
}

/// Matrices are twelve numbers in the tables, row by row.
Vec3f rows(const Machine& m, const Operation& o, float w) {
  const float* t = m.tables + o.data;
  const Vec3f& v = m.in(o, 0);
  return {t[0] * v.x + t[1] * v.y + t[2] * v.z + t[3] * w, t[4] * v.x + t[5] * v.y + t[6] * v.z + t[7] * w,
          t[8] * v.x + t[9] * v.y + t[10] * v.z + t[11] * w};
}
void transform_point(Machine& m, const Operation& o) {
  m.set(o, rows(m, o, 1));
}
void transform_direction(Machine& m, const Operation& o) {
  m.set(o, rows(m, o, 0));
}

template <int I>
void component(Machine& m, const Operation& o) {
  m.set(o, m.in(o, 0)[I]);
}
void combine(Machine& m, const Operation& o) {
  m.set(o, Vec3f{m.number(o, 0), m.number(o, 1), m.number(o, 2)});
}
void average(Machine& m, const Operation& o) {
  const Vec3f& v = m.in(o, 0);
  m.set(o, (v.x + v.y + v.z) / 3);
}

using V = const Vec3f&;

constexpr NamedOperation kOperations[] = {
    {"vector.ADD", vector<[](V a, V b, V) { return a + b; }>},
    {"vector.SUBTRACT", vector<[](V a, V b, V) { return a - b; }>},
    {"vector.MULTIPLY", vector<[](V a, V b, V) { return a * b; }>},
    {"vector.MULTIPLY_ADD", vector<[](V a, V b, V c) { return a * b + c; }>},
    {"vector.DIVIDE", by_component<kDivide>},
    {"vector.CROSS_PRODUCT", vector<[](V a, V b, V) { return cross(a, b); }>},
    {"vector.PROJECT", vector<[](V a, V b, V) { return project(a, b); }>},
    {"vector.REFLECT", vector<[](V a, V b, V) { return reflect(a, normalize(b)); }>},
    {"vector.REFRACT", refract},
    {"vector.FACEFORWARD", vector<[](V a, V b, V c) { return dot(c, b) < 0 ? a : -a; }>},
    {"vector.DOT_PRODUCT", vector<[](V a, V b, V) { return dot(a, b); }>},
    {"vector.DISTANCE", vector<[](V a, V b, V) { return length(a - b); }>},
    {"vector.LENGTH", vector<[](V a, V, V) { return length(a); }>},
    {"vector.NORMALIZE", vector<[](V a, V, V) { return normalize(a); }>},
    {"vector.SCALE", vector<[](V a, V b, V) { return a * b.x; }>},
    {"vector.SNAP",
     by_component<[](float a, float b, float) { return b != 0 ? std::floor(a / b) * b : 0.0f; }>},
    {"vector.FLOOR", by_component<[](float a, float, float) { return std::floor(a); }>},
    {"vector.CEIL", by_component<[](float a, float, float) { return std::ceil(a); }>},
    {"vector.MODULO", by_component<[](float a, float b, float) { return b != 0 ? std::fmod(a, b) : 0.0f; }>},
    {"vector.WRAP", by_component<wrap>},
    {"vector.FRACTION", by_component<[](float a, float, float) { return a - std::floor(a); }>},
    {"vector.ABSOLUTE", by_component<[](float a, float, float) { return std::abs(a); }>},
    {"vector.MINIMUM", by_component<[](float a, float b, float) { return std::min(a, b); }>},
    {"vector.MAXIMUM", by_component<[](float a, float b, float) { return std::max(a, b); }>},
    {"vector.SINE", by_component<[](float a, float, float) { return std::sin(a); }>},
    {"vector.COSINE", by_component<[](float a, float, float) { return std::cos(a); }>},
    {"vector.TANGENT", by_component<[](float a, float, float) { return std::tan(a); }>},
    {"mapping.POINT", mapping_point},
    {"mapping.TEXTURE", mapping_texture},
    {"mapping.VECTOR", mapping_vector},
    {"mapping.NORMAL", mapping_normal},
    {"transform.point", transform_point, true, DataKind::kMatrix},
    {"transform.direction", transform_direction, true, DataKind::kMatrix},
    {"separate.x", component<0>},
    {"separate.y", component<1>},
    {"separate.z", component<2>},
    {"combine", combine},
    {"average", average},
};

}  // namespace

std::span<const NamedOperation> vector_operations() {
  return kOperations;
}

}  // namespace penumbra
