// SPDX-License-Identifier: Apache-2.0
// Opens files that somebody named, for reading. Where a name is that of a FIFO, open() waits for a writer that may
// never come; a device may have no end, and opening it may do something. So a file is opened without waiting, looked at
// through its descriptor, and refused where it is not a regular file. A look at the name before it is opened would not
// do: between the two it may become something else.
#pragma once

#include <ext/stdio_filebuf.h>

#include <cstddef>
#include <istream>
#include <string>

#include "host/foundation/base/files/open_file.h"

namespace multum {

/// Whether "/dev/stdin" may name what the program was given as standard input: a pipe, or a terminal. It is read once
/// and from its beginning, so only readers of whole texts allow it.
enum class StandardInput { kRefused, kAllowed };

/// Opens `path` for reading. Not open, with errno, where it is not there or may not be read. Throws Error(kInput) where
/// it is a folder, a FIFO, a socket or a device: "PATH: is a FIFO, expected a regular file"; Error(kEnvironment) where
/// this process may open no more files, or has no memory; Error(kUsage) for a name that no file system takes.
OpenFile open_regular_file(const std::string& path, StandardInput input = StandardInput::kRefused);

/// As open_regular_file(), with `folder` and all that links lead to: a file that lies beneath `folder` by its real
/// name. Throws Error(kInput) also where it lies elsewhere.
OpenFile open_file_beneath(const std::string& folder, const std::string& path);

/// As many of the first bytes as there are, up to `count`; none of a folder, or of a file that cannot be read. Throws
/// Error(kInput) as open_regular_file() does, but for a folder.
std::string first_bytes(const std::string& path, std::size_t count);

/// std::ifstream for files that somebody named.
class RegularFileStream : public std::istream {
 public:
  /// Fails as std::ifstream does where the file cannot be opened; otherwise as open_regular_file().
  explicit RegularFileStream(const std::string& path, StandardInput input = StandardInput::kRefused);
  explicit RegularFileStream(OpenFile file);

 private:
  __gnu_cxx::stdio_filebuf<char> buffer_;
};

}  // namespace multum
