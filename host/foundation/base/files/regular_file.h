// SPDX-License-Identifier: Apache-2.0
// Opens files that users name, for reading. If the file is a FIFO, open() waits for a writer that may never come. A
// device may have no end, and opening a device can have side effects. Therefore a file is opened without waiting,
// examined through its descriptor, and rejected unless it is a regular file. A check of the name before opening would
// not suffice, because the file can be replaced in between.
#pragma once

#include <ext/stdio_filebuf.h>

#include <cstddef>
#include <istream>
#include <string>

#include "host/foundation/base/files/open_file.h"

namespace multum {

/// Selects whether "/dev/stdin" may name the program's standard input if that is a pipe or a terminal. Standard input
/// can only be read once and from its beginning, so only readers of whole texts allow it.
enum class StandardInput { kRefused, kAllowed };

/// Opens `path` for reading. If the file is missing or not readable, the result is not open, and errno gives the
/// reason. Throws Error(kInput) for a folder, a FIFO, a socket or a device: "PATH: is a FIFO, expected a regular file".
/// Throws Error(kEnvironment) if this process has no memory left or cannot open more files. Throws Error(kUsage) for a
/// name that no file system accepts.
OpenFile open_regular_file(const std::string& path, StandardInput input = StandardInput::kRefused);

/// Works like open_regular_file(), but also resolves `folder` and all links. The real name of the file must be beneath
/// `folder`. Otherwise throws Error(kInput).
OpenFile open_file_beneath(const std::string& folder, const std::string& path);

/// Returns up to `count` bytes from the beginning of the file. Returns no bytes for a folder or an unreadable file.
/// Otherwise throws Error(kInput) like open_regular_file().
std::string first_bytes(const std::string& path, std::size_t count);

/// A std::ifstream for files that users name.
class RegularFileStream : public std::istream {
 public:
  /// Fails like std::ifstream if the file cannot be opened. Otherwise throws like open_regular_file().
  explicit RegularFileStream(const std::string& path, StandardInput input = StandardInput::kRefused);
  explicit RegularFileStream(OpenFile file);

 private:
  __gnu_cxx::stdio_filebuf<char> buffer_;
};

}  // namespace multum
