// SPDX-License-Identifier: Apache-2.0
// Holds the unfinished work of one process in a folder. The folder has mode 0700, is locked, and is used, emptied and
// removed only through its descriptor. Every command keeps unfinished work in such a folder. The folder is next to the
// output of the command, or in a hidden folder that is named after the output. If somebody else puts a link or a folder
// there, the program neither writes to it nor removes anything behind it (own_folder.h).
#pragma once

#include <memory>
#include <string>

#include "host/foundation/base/files/open_file.h"
#include "host/foundation/base/files/own_folder.h"

namespace multum {

class WorkFolder {
 public:
  /// Creates the folder `path`, or takes an existing one with its contents. Returns null if another living process owns
  /// the folder. If it is not an own folder, leaves it unchanged and throws Error(kEnvironment), which gives the
  /// reason.
  static std::unique_ptr<WorkFolder> take(const std::string& path);
  /// Creates a new work folder with a random name in `folder`, and removes work folders that remain there because their
  /// runs were killed. Throws Error(kEnvironment).
  static std::unique_ptr<WorkFolder> make(const std::string& folder);
  /// Removes the folders that make() created in `folder` for runs that were then killed, and nothing else.
  static void sweep(const std::string& folder);
  /// Takes and removes the folder `path`. Does not touch it if take() would reject it, or if another process owns it.
  static void drop(const std::string& path);
  /// Removes the folder and its contents, unless leave() was called.
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  /// A path that leads to this folder while this object exists, even if the folder is renamed. The path is valid in
  /// this process and its children.
  const std::string& path() const { return path_; }
  /// The folder's name, for messages.
  const std::string& shown_path() const { return shown_path_; }
  int descriptor() const { return folder_.descriptor(); }
  /// Removes the contents, except for the entry `kept`. Throws Error(kEnvironment) when anything else remains.
  void clear(const std::string& kept = "") const;
  /// Keeps the folder when this object is destroyed, so that interrupted work can be resumed. If false, which is the
  /// default, the folder is removed.
  void leave(bool stays = true) { stays_ = stays; }

 private:
  WorkFolder(NamedPlace place, OpenFile folder, std::string shown_path);

  NamedPlace place_;
  OpenFile folder_;
  std::string path_, shown_path_;
  bool stays_ = false;
};

/// Returns the hidden folder for unfinished work next to an output, .multum-partial-NAME.
std::string partial_folder_of(const std::string& output);

}  // namespace multum
