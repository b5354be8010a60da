// SPDX-License-Identifier: Apache-2.0
// Finds and checks file names before any work begins.
#pragma once

#include <string>
#include <vector>

namespace multum {

/// Throws Error(kUsage) if an output is also an input or another output, even under a different name, because the
/// result would silently replace a source or another result. Also throws if the name of an output holds a control
/// character. An empty name means that there is no file.
void check_paths_differ(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

/// Resolves `path`, which is relative to the folder of `file`. An empty path, which means no file, stays empty.
std::string path_beside(const std::string& file, const std::string& path);

/// Returns one name that is the same for all names of a file. The file does not need to exist yet.
std::string canonical_name(const std::string& path);

/// Creates a folder and its parent folders if they are missing. Throws Error(kEnvironment) if this fails, and
/// Error(kUsage) for a new name that holds a control character.
void make_folder(const std::string& path);

/// Creates the folder that will contain `file`, like make_folder(). Does nothing if the name has no folder.
void make_folder_of(const std::string& file);

/// Records the folders that make_folder() creates while the object exists. The destructor removes those that are empty.
/// Every command has such an object, so a command that rejects its input leaves no folder.
class NewFolders {
 public:
  NewFolders();
  ~NewFolders();
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;
};

/// Returns the longest existing part of the folder that contains, or would contain, `path`.
std::string existing_part(const std::string& path);

/// Throws Error(kEnvironment) if no file of this name can be written, or Error(kUsage) if the name belongs to a folder
/// or holds a control character. Leaves no file.
void check_writable(const std::string& path);

}  // namespace multum
