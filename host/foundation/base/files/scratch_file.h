// SPDX-License-Identifier: Apache-2.0
// A file for what does not fit in memory. It has no name, so that it is gone when the object is, or the process; unless
// it is given one, by which a later process finds it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "host/foundation/base/files/work_folder.h"

namespace multum {

class ScratchFile {
 public:
  /// Throws Error(kEnvironment) when the folder does not exist or cannot be written.
  explicit ScratchFile(std::string folder);
  /// Opens a file of that name: what an earlier process wrote to it is there. Throws likewise.
  ScratchFile(const WorkFolder& folder, const std::string& name);
  /// The same in the folder of a WorkFolder's path().
  ScratchFile(std::string folder, const std::string& name);
  /// Opens a file that is there, to be read alone.
  static ScratchFile to_read(const std::string& path);
  ~ScratchFile();
  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&& other) noexcept;

  /// Anywhere, also beyond the end. Throws Error(kEnvironment) when the disk refuses (it is full).
  void write(std::uint64_t offset, const void* data, std::size_t byte_count);
  /// Reads what was written there. Any number of threads may read at once.
  void read(std::uint64_t offset, void* data, std::size_t byte_count) const;

 private:
  ScratchFile() = default;

  std::string folder_;
  int descriptor_ = -1;
};

}  // namespace multum
