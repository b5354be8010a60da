// SPDX-License-Identifier: Apache-2.0
// Writes bytes to an AtomicFile for libraries that write through callbacks: the first thing that goes wrong is kept and
// thrown when the file is closed, since what is thrown within a callback may not arrive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

#include "host/foundation/base/files/atomic_file.h"

namespace multum {

class OutputFile {
 public:
  /// From its first byte on; `file` outlives this. Throws Error(kEnvironment).
  explicit OutputFile(const AtomicFile& file);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// False when the system refuses.
  bool write(const void* bytes, std::size_t count);
  bool seek(std::uint64_t position);
  std::uint64_t position() const { return position_; }
  /// The first failure, as text; empty: there was none.
  std::string failure() const;
  /// Hands everything to the system. Throws Error(kEnvironment) when this or anything before it failed.
  void close();

 private:
  bool keep(bool succeeded);
  std::string shown_path_;
  std::FILE* file_;
  std::uint64_t position_ = 0;
  int failure_ = 0;  // the first errno
};

/// Writes where nothing stands between the writer and whoever may hear of a failure: ends the work at once when the
/// system refuses. Throws Error(kEnvironment).
inline void write_or_throw(OutputFile& file, const void* bytes, std::size_t count) {
  if (!file.write(bytes, count)) file.close();  // throws what has failed
}

}  // namespace multum
