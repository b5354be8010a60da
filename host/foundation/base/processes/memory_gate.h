// SPDX-License-Identifier: Apache-2.0
// Makes threads wait until the memory that they need in total fits into a limit.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace multum {

class MemoryGate {
 public:
  explicit MemoryGate(std::uint64_t bytes_max) : bytes_max_(bytes_max) {}

  /// Waits until `bytes` additional bytes fit, or until no other thread holds memory. The destructor returns the bytes.
  class Pass {
   public:
    Pass(MemoryGate& gate, std::uint64_t bytes) : gate_(gate), bytes_(bytes) {
      std::unique_lock lock(gate.mutex_);
      gate.left_.wait(lock, [&] { return gate.bytes_ == 0 || gate.bytes_ + bytes <= gate.bytes_max_; });
      gate.bytes_ += bytes;
    }
    ~Pass() {
      {
        const std::lock_guard lock(gate_.mutex_);
        gate_.bytes_ -= bytes_;
      }
      gate_.left_.notify_all();
    }
    Pass(const Pass&) = delete;
    Pass& operator=(const Pass&) = delete;

   private:
    MemoryGate& gate_;
    const std::uint64_t bytes_;
  };

 private:
  const std::uint64_t bytes_max_;
  std::mutex mutex_;
  std::condition_variable left_;
  std::uint64_t bytes_ = 0;
};

}  // namespace multum
