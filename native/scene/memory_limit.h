// SPDX-License-Identifier: GPL-3.0-or-later
// A limit on memory that ends in an error instead of a dead process.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <new>
#include <string>

namespace penumbra {

/// std::bad_alloc that says which limit was reached, and for what.
class MemoryLimitReached : public std::bad_alloc {
 public:
  MemoryLimitReached(uint64_t limit_bytes, const std::string& what)
      : text_(std::make_shared<std::string>("memory_limit of " + std::to_string(limit_bytes >> 20) +
                                            " MiB reached: " + what)) {}
  const char* what() const noexcept override { return text_->c_str(); }

 private:
  std::shared_ptr<const std::string> text_;  // so that copying cannot throw
};

/// Counts bytes against a limit; any number of threads.
class MemoryCount {
 public:
  /// Bytes; 0: no limit.
  explicit MemoryCount(uint64_t limit = 0) : limit_(limit) {}

  /// From now on; what is in use counts.
  void set_limit(uint64_t limit) {
    limit_ = limit;
    exceeded_ = false;
  }

  /// Adds bytes (or takes some back). False once more than the limit are in use.
  bool add(int64_t bytes) {
    const int64_t used = used_ += bytes;
    const uint64_t limit = limit_;
    if (limit == 0 || bytes <= 0 || uint64_t(used) <= limit) return true;
    exceeded_ = true;
    return false;
  }
  bool exceeded() const { return exceeded_; }
  uint64_t limit() const { return limit_; }

 private:
  std::atomic<uint64_t> limit_;
  std::atomic<int64_t> used_{0};
  std::atomic<bool> exceeded_{false};
};

}  // namespace penumbra
