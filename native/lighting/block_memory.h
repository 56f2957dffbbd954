// SPDX-License-Identifier: GPL-3.0-or-later
// Large arrays that one block after the other uses.
#pragma once

#include <memory>
#include <typeindex>
#include <unordered_map>
#include <utility>
#include <vector>

namespace penumbra {

/// The arrays that the blocks of one thread have done with. If each block gave them back to the system, it
/// would map and zero their pages anew for the next: two fifths of a render with little to refine.
class BlockMemory {
 public:
  BlockMemory() = default;
  BlockMemory(const BlockMemory&) = delete;
  BlockMemory& operator=(const BlockMemory&) = delete;

 private:
  template <typename T>
  friend class Reused;

  struct Idle {
    virtual ~Idle() = default;
  };
  template <typename T>
  struct IdleVector : Idle {
    explicit IdleVector(std::vector<T> v) : vector(std::move(v)) {}
    std::vector<T> vector;
  };
  std::unordered_map<std::type_index, std::vector<std::unique_ptr<Idle>>> idle_;  // by the elements' type
};

/// A vector in the memory of one that is no longer used. The BlockMemory must live longer.
template <typename T>
class Reused : public std::vector<T> {
 public:
  explicit Reused(BlockMemory& memory) : idle_(memory.idle_[typeid(T)]) {
    if (idle_.empty()) return;
    this->swap(static_cast<BlockMemory::IdleVector<T>&>(*idle_.back()).vector);
    idle_.pop_back();
  }
  Reused(BlockMemory& memory, size_t size, const T& value = {}) : Reused(memory) {
    this->assign(size, value);
  }
  Reused(const Reused&) = delete;
  Reused& operator=(const Reused&) = delete;
  ~Reused() {
    this->clear();  // what its elements own is not kept
    try {
      idle_.push_back(std::make_unique<BlockMemory::IdleVector<T>>(std::move(*this)));
    } catch (...) {  // no memory for it: then this goes, too
    }
  }

 private:
  std::vector<std::unique_ptr<BlockMemory::Idle>>& idle_;
};

}  // namespace penumbra
