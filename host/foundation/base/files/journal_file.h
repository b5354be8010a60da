// SPDX-License-Identifier: Apache-2.0
// A file of a WorkFolder that only grows: records are read once when work goes on, a torn end is cut off, and then
// others are appended. Every record is on its own: what a kill or a full disk leaves of one is removed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "host/foundation/base/files/open_file.h"
#include "host/foundation/base/files/work_folder.h"

namespace multum {

class JournalFile {
 public:
  /// Opens the file `name` of `folder`, and makes it if it is missing. Throws Error(kEnvironment), also when something
  /// else than a file has this name.
  JournalFile(const WorkFolder& folder, const std::string& name);

  /// Bytes in the file.
  std::uint64_t size() const { return size_; }
  /// Reads `bytes.size()` bytes from `offset` on. False: the file ends before, or the disk refuses.
  bool read(std::uint64_t offset, std::span<std::uint8_t> bytes) const;
  /// The line that begins at `offset`, without its end. Empty optional: none ends within `length_max` bytes.
  std::optional<std::string> line(std::uint64_t offset, std::size_t length_max) const;
  /// Leaves the first `size` bytes only. Throws Error(kEnvironment).
  void cut(std::uint64_t size);
  /// Appends these parts. Throws Error(kEnvironment) when the disk refuses; nothing of them stays in the file.
  void append(std::span<const std::span<const std::uint8_t>> parts);
  /// Appends a line and its end. Throws likewise.
  void append_line(const std::string& line);
  /// The file's name, for messages.
  const std::string& shown_path() const { return shown_path_; }

 private:
  std::string shown_path_;
  OpenFile file_;
  std::uint64_t size_ = 0;
};

}  // namespace multum
