// SPDX-License-Identifier: Apache-2.0
// Writes a file that appears complete or not at all. The bytes go to a temporary file in the same folder, which is then
// synced and renamed. The temporary file is new, has a random name, and is written through its descriptor. If somebody
// puts a link, a pipe or another file in its place, the program neither follows nor writes to that object.
#pragma once

#include <string>
#include <string_view>

#include "host/foundation/base/files/open_file.h"
#include "host/foundation/base/files/own_folder.h"

namespace multum {

class AtomicFile {
 public:
  /// Creates the temporary file. Removes temporary files for the same final name that earlier runs of this user left
  /// when they were killed. Throws Error(kUsage) if the name is too long or belongs to a folder, a device or a pipe.
  /// Throws Error(kEnvironment) if the folder is missing or no file can be created in it.
  explicit AtomicFile(std::string path);
  /// Removes the temporary file unless commit() was reached.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// The descriptor is open for reading and writing.
  int descriptor() const { return file_.descriptor(); }
  /// Returns a path to the open file itself, for functions that take names. The path is valid in this process and its
  /// children.
  const std::string& open_path() const { return open_path_; }
  const std::string& path() const { return path_; }
  /// Syncs the temporary file and its folder, and gives the file its final name. Throws Error(kEnvironment) if this
  /// fails, or if the temporary name now belongs to another file.
  void commit();

 private:
  std::string path_, temporary_name_, open_path_;
  NamedPlace place_;
  OpenFile file_;
  bool committed_ = false;
};

/// Returns whether `name` has the form of a temporary file that an AtomicFile of this or any other process makes.
bool is_temporary_name(std::string_view name);

/// Writes a small text file atomically.
void write_text_file(const std::string& path, std::string_view text);

}  // namespace multum
