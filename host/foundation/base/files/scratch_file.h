// SPDX-License-Identifier: Apache-2.0
// Stores data that do not fit in memory. An unnamed scratch file disappears with its object or its process. A named
// scratch file can be found by a later process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "host/foundation/base/files/work_folder.h"

namespace multum {

class ScratchFile {
 public:
  /// Throws Error(kEnvironment) if the folder does not exist or is not writable.
  explicit ScratchFile(std::string folder);
  /// Opens the file with this name and keeps the data that an earlier process wrote to it. Also throws
  /// Error(kEnvironment).
  ScratchFile(const WorkFolder& folder, const std::string& name);
  /// Like the constructor above, with the path() of a WorkFolder.
  ScratchFile(std::string folder, const std::string& name);
  /// Opens an existing file for reading only.
  static ScratchFile to_read(const std::string& path);
  ~ScratchFile();
  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&& other) noexcept;

  /// Writes at any position, even beyond the end. Throws Error(kEnvironment) if the disk fails (for example, if it is
  /// full).
  void write(std::uint64_t offset, const void* data, std::size_t byte_count);
  /// Reads data that were written before. Any number of threads may read at once.
  void read(std::uint64_t offset, void* data, std::size_t byte_count) const;

 private:
  ScratchFile() = default;

  std::string folder_;
  int descriptor_ = -1;
};

}  // namespace multum
