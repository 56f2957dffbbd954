// SPDX-License-Identifier: GPL-3.0-or-later
// Counter-based hashing: what makes a sample depend on (pixel, seed, luminaire, index) alone.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace penumbra {

/// Bijective 64-bit finaliser of SplitMix64 (Steele, Lea, Flood 2014, variant 13 of Stafford's mixers).
constexpr uint64_t mix_bits(uint64_t x) {
  x ^= x >> 30;
  x *= 0xBF58476D1CE4E5B9u;
  x ^= x >> 27;
  x *= 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

/// Hash of any number of integers, order-sensitive.
template <typename... T>
constexpr uint64_t hash_of(uint64_t first, T... rest) {
  uint64_t h = mix_bits(first + 0x9E3779B97F4A7C15u);
  ((h = mix_bits(h ^ (uint64_t(rest) + 0x9E3779B97F4A7C15u))), ...);
  return h;
}

/// Hash of memory that continues h, eight bytes at a time; the rest padded with zeros.
inline uint64_t hash_bytes(uint64_t h, const void* data, size_t size) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (size_t i = 0; i < size; i += 8) {
    uint64_t word = 0;
    std::memcpy(&word, bytes + i, std::min<size_t>(8, size - i));
    h = (h ^ word) * 0x9E3779B97F4A7C15u;
    h ^= h >> 32;
  }
  return mix_bits(h ^ size);
}

constexpr uint32_t reverse_bits(uint32_t x) {
  x = (x >> 16) | (x << 16);
  x = ((x & 0x00FF00FFu) << 8) | ((x >> 8) & 0x00FF00FFu);
  x = ((x & 0x0F0F0F0Fu) << 4) | ((x >> 4) & 0x0F0F0F0Fu);
  x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
  return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
}

/// Nested uniform (Owen) scrambling of a bit-reversed fraction: bit k of the result depends on bits 0..k of
/// the input alone. Laine and Karras 2011, with the constants of Burley, JCGT 9(4), 2020.
constexpr uint32_t owen_scramble_reversed(uint32_t x, uint32_t seed) {
  x += seed;
  x ^= x * 0x6C50B47Cu;
  x ^= x * 0xB82F1E52u;
  x ^= x * 0xC7AFE638u;
  x ^= x * 0x8D22F6E6u;
  return x;
}

/// Likewise of an array's elements. Four stretches at a time: each step of a hash waits for the one before.
template <typename T>
uint64_t hash_array(uint64_t h, const std::vector<T>& values) {
  constexpr size_t kLanes = 4, kWord = sizeof(uint64_t), kWorthIt = 4096;
  const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
  const size_t size = values.size() * sizeof(T);
  if (size < kWorthIt) return hash_bytes(h, bytes, size);
  const size_t stretch = size / kLanes / kWord * kWord;
  uint64_t lanes[kLanes] = {h, h + 1, h + 2, h + 3};
  for (size_t i = 0; i < stretch; i += kWord)
    for (size_t k = 0; k < kLanes; ++k) {
      uint64_t word;
      std::memcpy(&word, bytes + k * stretch + i, kWord);
      lanes[k] = (lanes[k] ^ word) * 0x9E3779B97F4A7C15u;
      lanes[k] ^= lanes[k] >> 32;
    }
  h = hash_of(lanes[0], lanes[1], lanes[2], lanes[3], uint64_t(size));
  return hash_bytes(h, bytes + kLanes * stretch, size - kLanes * stretch);
}

}  // namespace penumbra
