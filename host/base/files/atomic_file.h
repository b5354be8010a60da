// SPDX-License-Identifier: Apache-2.0
// A file that appears whole or not at all: it is written under a temporary name in the same folder, synced, and
// renamed.
#pragma once

#include <string>
#include <string_view>

namespace multum {

class AtomicFile {
 public:
  /// Checks that the folder exists and can be written, and removes temporary files that killed runs left for the same
  /// final name. Throws Error(kEnvironment) otherwise.
  explicit AtomicFile(std::string path);
  /// Removes the temporary file when commit() was never reached.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Write here. It keeps the final name's extension, since image libraries choose the format by it.
  const std::string& temporary_path() const { return temporary_path_; }
  const std::string& path() const { return path_; }
  /// Syncs the temporary file and its folder, and gives it its final name.
  void commit();

 private:
  std::string path_;
  std::string temporary_path_;
  bool committed_ = false;
};

/// Is this file name a temporary one, of an AtomicFile in any process?
bool is_temporary_name(std::string_view name);

/// Writes a small text file atomically.
void write_text_file(const std::string& path, std::string_view text);

}  // namespace multum
