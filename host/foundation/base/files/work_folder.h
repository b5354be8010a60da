// SPDX-License-Identifier: Apache-2.0
// A folder for the work of one process: made with mode 0700, locked, and from then on used, emptied and removed through
// its descriptor. Every command keeps unfinished work in one, next to its output or in a hidden folder of that name, so
// a link or a folder that somebody else put there is never written to, and nothing behind it is ever removed
// (own_folder.h).
#pragma once

#include <memory>
#include <string>

#include "host/foundation/base/files/open_file.h"
#include "host/foundation/base/files/own_folder.h"

namespace multum {

class WorkFolder {
 public:
  /// Makes the folder `path`, or takes the one that is there with all that it holds. Null while another living process
  /// has it. Throws Error(kEnvironment) for what is not ours, names what was found, and leaves it alone.
  static std::unique_ptr<WorkFolder> take(const std::string& path);
  /// Makes a new one in `folder`, of a name that nobody can guess, and removes those that killed runs left there.
  /// Throws Error(kEnvironment).
  static std::unique_ptr<WorkFolder> make(const std::string& folder);
  /// Removes what killed runs of make() left in `folder`, nothing else.
  static void sweep(const std::string& folder);
  /// Takes and removes the folder `path`. Leaves alone what take() would refuse or another process has.
  static void drop(const std::string& path);
  /// Removes the folder and all in it, unless leave() was called.
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  /// Leads to this very folder while this object lives, whatever becomes of its name; for this process and those that
  /// it starts.
  const std::string& path() const { return path_; }
  /// The folder's name, for messages.
  const std::string& shown_path() const { return shown_path_; }
  int descriptor() const { return folder_.descriptor(); }
  /// Removes what is in it, except for the entry `kept`. Throws Error(kEnvironment) when something else stays.
  void clear(const std::string& kept = "") const;
  /// The folder stays when this is destroyed: the work was stopped and may go on. False: it goes, as at first.
  void leave(bool stays = true) { stays_ = stays; }

 private:
  WorkFolder(NamedPlace place, OpenFile folder, std::string shown_path);

  NamedPlace place_;
  OpenFile folder_;
  std::string path_, shown_path_;
  bool stays_ = false;
};

/// The hidden folder of unfinished work next to an output, .multum-partial-NAME.
std::string partial_folder_of(const std::string& output);

}  // namespace multum
