// SPDX-License-Identifier: Apache-2.0
// Reads bytes of a file by position, to examine the file before a library reads it. A read past the end of the file is
// an error that names the missing part.
#pragma once

#include <cstdint>
#include <string>

#include "host/foundation/base/files/open_file.h"

namespace multum {

class ByteFile {
 public:
  /// Throws Error(kInput) if the file is missing, not a regular file, or not readable.
  explicit ByteFile(const std::string& path);
  /// Reads a file that is already open; messages name `path`.
  ByteFile(OpenFile file, const std::string& path);
  std::int64_t size() const { return size_; }

  // Return the `count` bytes at `position`, as bytes or as an integer; `what` names these bytes in messages. Throw
  // Error(kInput) if the file is too short.
  std::string bytes(std::int64_t position, std::int64_t count, const char* what);
  std::int64_t big_endian(std::int64_t position, int count, const char* what);
  std::int64_t little_endian(std::int64_t position, int count, const char* what);
  /// Reads straight into memory; several threads may call this at once.
  void read(std::int64_t position, std::int64_t count, void* memory, const char* what) const;

 private:
  void check_range(std::int64_t position, std::int64_t count, const char* what) const;

  std::string path_;
  OpenFile file_;
  std::int64_t size_ = 0;
  std::string window_;  // a block of bytes that was read at once, from window_begin_ on
  std::int64_t window_begin_ = 0;
};

/// Returns all bytes of a file that this program has written. Throws Error(kEnvironment) when the file is missing or
/// empty.
std::string bytes_of_file(const std::string& path);

}  // namespace multum
