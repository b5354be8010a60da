// SPDX-License-Identifier: Apache-2.0
// Reads bytes of a file by position, to examine the file before a library reads it. A read past the end of the file
// causes an error that names the missing part.
#pragma once

#include <cstdint>
#include <string>

#include "host/foundation/base/files/open_file.h"

namespace multum {

class ByteFile {
 public:
  /// Throws Error(kInput) if the file is missing, is not a regular file, or cannot be read.
  explicit ByteFile(const std::string& path);
  /// Reads a file that is already open. Messages name `path`.
  ByteFile(OpenFile file, const std::string& path);
  std::int64_t size() const { return size_; }

  // Return the `count` bytes at `position`, as bytes or as an integer. Messages call these bytes `what`. Throw
  // Error(kInput) if the file is too short.
  std::string bytes(std::int64_t position, std::int64_t count, const char* what);
  std::int64_t big_endian(std::int64_t position, int count, const char* what);
  std::int64_t little_endian(std::int64_t position, int count, const char* what);
  /// Reads directly into memory. Several threads may call this function at once.
  void read(std::int64_t position, std::int64_t count, void* memory, const char* what) const;

 private:
  void check_range(std::int64_t position, std::int64_t count, const char* what) const;

  std::string path_;
  OpenFile file_;
  std::int64_t size_ = 0;
  std::string window_;  // a block that was read at once, beginning at window_begin_
  std::int64_t window_begin_ = 0;
};

/// Returns all bytes of a file that this program has written. Throws Error(kEnvironment) if the file is missing or
/// empty.
std::string bytes_of_file(const std::string& path);

}  // namespace multum
