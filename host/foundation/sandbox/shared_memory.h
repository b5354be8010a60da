// SPDX-License-Identifier: Apache-2.0
// Shares memory between two processes through an unnamed file (memfd), which disappears when neither process uses it.
#pragma once

#include <cstddef>

namespace multum {

class SharedMemory {
 public:
  /// Creates shared memory. Throws Error(kEnvironment) if the system cannot provide it.
  SharedMemory();
  /// Uses the memory of another process through a descriptor from that process. Does not close the descriptor.
  explicit SharedMemory(int descriptor);
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  int descriptor() const { return descriptor_; }
  /// Returns memory of at least `byte_count` bytes. The address may have changed. The memory keeps its earlier
  /// contents, and new bytes are zero. The memory never shrinks, because a process that maps more memory than exists
  /// would crash.
  std::byte* reserve(std::size_t byte_count);
  /// Maps the whole memory at its present size, because the other process may have extended it.
  std::byte* see(std::size_t& byte_count);

 private:
  void map(std::size_t byte_count);
  int descriptor_ = -1;
  bool is_owner_ = false;
  std::byte* data_ = nullptr;
  std::size_t byte_count_ = 0;
};

}  // namespace multum
