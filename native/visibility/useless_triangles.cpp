// SPDX-License-Identifier: GPL-3.0-or-later
#include "visibility/useless_triangles.h"

#include <algorithm>
#include <array>
#include <bit>
#include <unordered_map>

#include "sampling/hash.h"

namespace penumbra {
namespace {

/// Adding zero turns -0 into 0.
uint64_t hash_of_place(const Vec3d& p) {
  const auto bits = [](double v) { return std::bit_cast<uint64_t>(v + 0.0); };
  return mix_bits(bits(p.x) * 3 + bits(p.y) * 0x9E3779B97F4A7C15u + std::rotl(bits(p.z), 32));
}

/// Independent of the corners' order.
uint64_t hash_of_corners(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return mix_bits(hash_of_place(a) + hash_of_place(b) + hash_of_place(c));
}

bool same_corners(const Mesh& mesh, size_t i, size_t k) {
  const auto &a = mesh.triangles[i], &b = mesh.triangles[k];
  return std::is_permutation(a.begin(), a.end(), b.begin(),
                             [&](uint32_t p, uint32_t q) { return mesh.positions[p] == mesh.positions[q]; });
}

/// One bit of each of some hashes, in a table of `bits_each` to twice as many bits each (a power of two).
class BitTable {
 public:
  BitTable(size_t hashes, size_t bits_each)
      : words_(std::max<size_t>(1, std::bit_ceil(hashes) * bits_each / 64)), mask_(words_.size() * 64 - 1) {}
  bool test(uint64_t hash) const { return words_[(hash & mask_) / 64] >> (hash % 64) & 1; }
  /// Whether it was set before.
  bool set(uint64_t hash) {
    uint64_t& word = words_[(hash & mask_) / 64];
    const uint64_t bit = uint64_t(1) << (hash % 64);
    const bool before = word & bit;
    word |= bit;
    return before;
  }

 private:
  std::vector<uint64_t> words_;
  uint64_t mask_;
};

/// Finds numbers whose hashes others may have, too: those that come to a bit that is set, and then all that
/// share a bit of a second table, of the hashes' upper halves, with one of these. Nearly all triangles of a
/// sound mesh have bits to themselves. Four bits a hash let 1 in 10 through, sixteen 1 in 20; but with
/// millions of hashes sixteen are no longer in the cache.
class Suspects {
 public:
  Suspects(size_t hashes, size_t bits_each) : seen_(hashes, bits_each) { tops_.reserve(hashes); }
  /// Gathered, so that the processor waits for many bits at a time: apart from what hashing takes.
  void add(uint64_t hash) {
    waiting_[waiting_count_++] = hash;
    if (waiting_count_ == waiting_.size()) look_up();
  }
  /// In the order in which they were added; of 32 bits, as Embree numbers triangles.
  std::vector<uint32_t> numbers() {
    look_up();
    BitTable shared(again_.size(), 16);
    for (const uint32_t top : again_) shared.set(top);
    std::vector<uint32_t> found;
    for (size_t k = 0; !again_.empty() && k < tops_.size(); ++k)
      if (shared.test(tops_[k])) found.push_back(uint32_t(k));
    return found;
  }
  uint32_t upper_half(uint32_t number) const { return tops_[number]; }

 private:
  void look_up() {
    for (size_t k = 0; k < waiting_count_; ++k) {
      tops_.push_back(uint32_t(waiting_[k] >> 32));
      if (seen_.set(waiting_[k])) again_.push_back(tops_.back());
    }
    waiting_count_ = 0;
  }

  BitTable seen_;
  std::vector<uint32_t> tops_, again_;
  std::array<uint64_t, 256> waiting_;
  size_t waiting_count_ = 0;
};

/// Which of the suspects are copies of others.
std::vector<uint32_t> find_copies(const Mesh& mesh, Suspects& all) {
  const std::vector<uint32_t> suspects = all.numbers();
  Suspects closer(suspects.size(), 16);
  for (const uint32_t i : suspects) closer.add(mix_bits(all.upper_half(i)));
  std::vector<uint32_t> copies;
  std::unordered_multimap<uint32_t, uint32_t> first_of;
  for (const uint32_t k : closer.numbers()) {
    const uint32_t i = suspects[k];
    const uint32_t hash = all.upper_half(i);
    const auto [begin, end] = first_of.equal_range(hash);
    if (std::any_of(begin, end, [&](const auto& e) { return same_corners(mesh, e.second, i); }))
      copies.push_back(i);
    else
      first_of.emplace(hash, i);
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
  Suspects suspects(n, 4);
  std::vector<bool> useless(n, false);
  for (size_t i = 0; i < n; ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const Vec3d &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
    suspects.add(hash_of_corners(p, q, r));
    if (cross(q - p, r - p) != Vec3d{}) continue;
    useless[i] = true;
    ++found.without_area;
  }
  for (const uint32_t i : find_copies(mesh, suspects)) {
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
