// SPDX-License-Identifier: GPL-3.0-or-later
#include "visibility/useless_triangles.h"

#include <algorithm>
#include <bit>
#include <unordered_map>

#include "sampling/hash.h"

namespace penumbra {
namespace {

using Corners = std::array<Vec3d, 3>;

Corners corners_of(const Mesh& mesh, size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  return {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
}

/// Independent of the corners' order. Adding zero turns -0 into 0.
uint64_t hash_of_corners(const Corners& corners) {
  const auto bits = [](double v) { return std::bit_cast<uint64_t>(v + 0.0); };
  uint64_t sum = 0;
  for (const Vec3d& c : corners)
    sum += mix_bits(bits(c.x) * 3 + bits(c.y) * 0x9E3779B97F4A7C15u + std::rotl(bits(c.z), 32));
  return mix_bits(sum);
}

bool same_corners(const Corners& a, const Corners& b) {
  return std::is_permutation(a.begin(), a.end(), b.begin());
}

/// A table of bits, 16 a triangle: nearly all triangles of a sound mesh have one to themselves.
class BitTable {
 public:
  explicit BitTable(size_t triangles)
      : words_(std::max<size_t>(1, std::bit_ceil(triangles) / 4)), mask_(words_.size() * 64 - 1) {}
  bool test(uint64_t hash) const { return words_[(hash & mask_) / 64] >> (hash % 64) & 1; }
  void set(uint64_t hash) { words_[(hash & mask_) / 64] |= uint64_t(1) << (hash % 64); }

 private:
  std::vector<uint64_t> words_;
  uint64_t mask_;
};

/// Numbers of hashes (all, or some of them) whose bit in a table others have, too. turn: chooses their bits.
std::vector<size_t> sharing_a_bit(const std::vector<uint64_t>& hashes, const std::vector<size_t>* some,
                                  int turn) {
  const size_t n = some ? some->size() : hashes.size();
  const auto number = [&](size_t k) { return some ? (*some)[k] : k; };
  BitTable seen(n), seen_twice(n);
  bool any = false;
  for (size_t k = 0; k < n; ++k) {
    const uint64_t hash = std::rotl(hashes[number(k)], turn);
    if (seen.test(hash)) seen_twice.set(hash), any = true;
    seen.set(hash);
  }
  std::vector<size_t> found;
  for (size_t k = 0; any && k < n; ++k)
    if (seen_twice.test(std::rotl(hashes[number(k)], turn))) found.push_back(number(k));
  return found;
}

/// Which triangles are copies. Only those that share two bits with others are looked at closely.
std::vector<size_t> find_copies(const Mesh& mesh, const std::vector<uint64_t>& hashes) {
  const std::vector<size_t> one_bit = sharing_a_bit(hashes, nullptr, 0);
  const std::vector<size_t> suspects = sharing_a_bit(hashes, &one_bit, 32);
  std::vector<size_t> copies;
  std::unordered_multimap<uint64_t, size_t> first_of;
  for (const size_t i : suspects) {
    const auto [begin, end] = first_of.equal_range(hashes[i]);
    const Corners own = corners_of(mesh, i);
    if (std::any_of(begin, end, [&](const auto& e) { return same_corners(corners_of(mesh, e.second), own); }))
      copies.push_back(i);
    else
      first_of.emplace(hashes[i], i);
  }
  return copies;
}

/// Keeps the elements (of `width` values each) that are not marked.
template <typename T>
void keep_unmarked(std::vector<T>& values, size_t width, const std::vector<bool>& marked) {
  if (values.empty()) return;
  size_t kept = 0;
  for (size_t i = 0; i < marked.size(); ++i) {
    if (marked[i]) continue;
    for (size_t k = 0; k < width; ++k) values[kept * width + k] = values[i * width + k];
    ++kept;
  }
  values.resize(kept * width);
}

}  // namespace

UselessTriangles remove_useless_triangles(Mesh& mesh) {
  UselessTriangles found;
  const size_t n = mesh.triangles.size();
  std::vector<uint64_t> hashes(n);
  std::vector<bool> useless(n, false);
  for (size_t i = 0; i < n; ++i) {
    const Corners c = corners_of(mesh, i);
    hashes[i] = hash_of_corners(c);
    if (cross(c[1] - c[0], c[2] - c[0]) != Vec3d{}) continue;
    useless[i] = true;
    ++found.without_area;
  }
  for (size_t i : find_copies(mesh, hashes)) {
    if (useless[i]) continue;
    useless[i] = true;
    ++found.copies;
  }
  if (found.count() == 0) return found;
  keep_unmarked(mesh.triangles, 1, useless);
  if (!mesh.normals_of_vertices) keep_unmarked(mesh.corner_normals, 3, useless);
  keep_unmarked(mesh.material_slots, 1, useless);
  for (Attribute& attribute : mesh.attributes) keep_unmarked(attribute.corners, 3, useless);
  return found;
}

}  // namespace penumbra
