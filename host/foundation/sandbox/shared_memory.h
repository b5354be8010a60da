// SPDX-License-Identifier: Apache-2.0
// Memory shared by two processes: a file without a name (memfd), gone when neither has it any more.
#pragma once

#include <cstddef>

namespace multum {

class SharedMemory {
 public:
  /// Throws Error(kEnvironment) when the machine has none to give.
  SharedMemory();
  /// Another process's, by the descriptor that was handed over; it is not closed.
  explicit SharedMemory(int descriptor);
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  int descriptor() const { return descriptor_; }
  /// At least so many bytes, zero where nobody wrote; what was there stays, perhaps at another address. It never
  /// shrinks: who sees more of it than there is would die.
  std::byte* reserve(std::size_t byte_count);
  /// The other process may have made it longer: all of it, as it is now.
  std::byte* see(std::size_t& byte_count);

 private:
  void map(std::size_t byte_count);
  int descriptor_ = -1;
  bool is_owner_ = false;
  std::byte* data_ = nullptr;
  std::size_t byte_count_ = 0;
};

}  // namespace multum
