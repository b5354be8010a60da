// SPDX-License-Identifier: Apache-2.0
// Receives an upload. The upload is written to an unnamed file as it arrives, and hashed. The file gets its name when
// it is complete. If the daemon dies before, nothing remains.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/open_file.h"

namespace multum {

class UploadFile {
 public:
  /// Creates the file in this folder. Throws Error(kEnvironment).
  explicit UploadFile(const std::string& folder);

  /// Blocks. Throws NoSpaceError when the disk is full, and Error(kEnvironment) for other failures.
  void write(std::string_view bytes);
  std::int64_t bytes() const { return bytes_; }
  /// Blocks. Syncs the file and gives it this name. The file is readable but not writable. An existing file of that
  /// name is kept. Throws Error(kEnvironment).
  void name(const std::string& path);
  /// Returns the hash of the written bytes. May be called only once.
  std::string sha256() { return hash_.finish(); }

 private:
  std::string folder_;
  OpenFile file_;
  ContentHash hash_;
  std::int64_t bytes_ = 0;
};

}  // namespace multum
