// SPDX-License-Identifier: Apache-2.0
// Writes bytes to an AtomicFile for libraries that write through callbacks. Exceptions must not pass through a
// callback. Therefore the first failure is stored, and thrown when the file is closed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

#include "host/foundation/base/files/atomic_file.h"

namespace multum {

class OutputFile {
 public:
  /// Starts writing at the first byte. `file` must outlive this object. Throws Error(kEnvironment).
  explicit OutputFile(const AtomicFile& file);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Returns false if the write fails.
  bool write(const void* bytes, std::size_t count);
  bool seek(std::uint64_t position);
  std::uint64_t position() const { return position_; }
  /// Returns a description of the first failure, or an empty text if nothing has failed.
  std::string failure() const;
  /// Passes all bytes to the system. Throws Error(kEnvironment) if this or an earlier write failed.
  void close();

 private:
  bool keep(bool succeeded);
  std::string shown_path_;
  std::FILE* file_;
  std::uint64_t position_ = 0;
  int failure_ = 0;  // the first errno
};

/// Writes for callers through which exceptions can pass. Throws Error(kEnvironment) as soon as a write fails.
inline void write_or_throw(OutputFile& file, const void* bytes, std::size_t count) {
  if (!file.write(bytes, count)) file.close();  // throws the stored failure
}

}  // namespace multum
