// SPDX-License-Identifier: Apache-2.0
// Owns a file descriptor and closes it in its destructor.
#pragma once

#include <unistd.h>

#include <utility>

namespace multum {

class OpenFile {
 public:
  /// Takes ownership of the descriptor. -1 means that there is no descriptor.
  explicit OpenFile(int descriptor = -1) : descriptor_(descriptor) {}
  OpenFile(OpenFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  OpenFile& operator=(OpenFile&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }
  /// Gives up ownership. The caller must close the descriptor.
  int release() { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_;
};

}  // namespace multum
