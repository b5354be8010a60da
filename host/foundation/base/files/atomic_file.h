// SPDX-License-Identifier: Apache-2.0
// A file that appears whole or not at all: it is written under a temporary name in the same folder, synced, and
// renamed. The temporary file is new, has a name that nobody can guess, and is written by its descriptor: a link, a
// pipe or another file that somebody puts in its way is neither followed nor written to.
#pragma once

#include <string>
#include <string_view>

#include "host/foundation/base/files/open_file.h"
#include "host/foundation/base/files/own_folder.h"

namespace multum {

class AtomicFile {
 public:
  /// Creates the temporary file, and removes those that killed runs of this user left for the same final name. Throws
  /// Error(kUsage) for a name that cannot be an output's: too long, a folder, a device, a pipe; Error(kEnvironment)
  /// when the folder is missing or refuses the file.
  explicit AtomicFile(std::string path);
  /// Removes the temporary file when commit() was never reached.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Open for reading and writing.
  int descriptor() const { return file_.descriptor(); }
  /// A path that leads to the open file itself, for what takes names; in this process and those that it starts.
  const std::string& open_path() const { return open_path_; }
  const std::string& path() const { return path_; }
  /// Syncs the temporary file and its folder, and gives it its final name. Throws Error(kEnvironment), also when the
  /// temporary name leads to something else by now.
  void commit();

 private:
  std::string path_, temporary_name_, open_path_;
  NamedPlace place_;
  OpenFile file_;
  bool committed_ = false;
};

/// Is this file name a temporary one, of an AtomicFile in any process?
bool is_temporary_name(std::string_view name);

/// Writes a small text file atomically.
void write_text_file(const std::string& path, std::string_view text);

}  // namespace multum
