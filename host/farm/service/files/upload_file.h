// SPDX-License-Identifier: Apache-2.0
// An upload on its way: written to a file without a name as it comes, and hashed. It gets its name when it is whole; a
// daemon that dies leaves nothing of it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/open_file.h"

namespace multum {

class UploadFile {
 public:
  /// In this folder. Throws Error(kEnvironment).
  explicit UploadFile(const std::string& folder);

  /// Blocks. Throws NoSpaceError when the disk is full, Error(kEnvironment) where it fails otherwise.
  void write(std::string_view bytes);
  std::int64_t bytes() const { return bytes_; }
  /// Blocks: syncs it, and names it so; a file that has the name already stays as it is. Readable, not writable.
  /// Throws Error(kEnvironment).
  void name(const std::string& path);
  /// Hash of what was written; called once.
  std::string sha256() { return hash_.finish(); }

 private:
  std::string folder_;
  OpenFile file_;
  ContentHash hash_;
  std::int64_t bytes_ = 0;
};

}  // namespace multum
