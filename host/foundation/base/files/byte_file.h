// SPDX-License-Identifier: Apache-2.0
// Reads bytes of a file by position, to examine it before a library sees it. A read past the end is an error that says
// what was being read.
#pragma once

#include <cstdint>
#include <string>

#include "host/foundation/base/files/open_file.h"

namespace multum {

class ByteFile {
 public:
  /// Throws Error(kInput): not there, not a regular file, not to be read.
  explicit ByteFile(const std::string& path);
  /// Of a file that is open; messages name `path`.
  ByteFile(OpenFile file, const std::string& path);
  std::int64_t size() const { return size_; }

  // Of `count` bytes there; `what` is what they are, for the message. Throw Error(kInput) where the file is cut.
  std::string bytes(std::int64_t position, std::int64_t count, const char* what);
  std::int64_t big_endian(std::int64_t position, int count, const char* what);
  std::int64_t little_endian(std::int64_t position, int count, const char* what);
  /// Reads straight into memory; several threads may at once.
  void read(std::int64_t position, std::int64_t count, void* memory, const char* what) const;

 private:
  void check_range(std::int64_t position, std::int64_t count, const char* what) const;

  std::string path_;
  OpenFile file_;
  std::int64_t size_ = 0;
  std::string window_;  // bytes that were read together, from window_begin_ on
  std::int64_t window_begin_ = 0;
};

/// All of a file that this program has written. Throws Error(kEnvironment) when it is not there, or empty.
std::string bytes_of_file(const std::string& path);

}  // namespace multum
