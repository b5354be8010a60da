// SPDX-License-Identifier: Apache-2.0
// Finds and checks file names before any work begins.
#pragma once

#include <string>
#include <vector>

namespace multum {

/// Throws Error(kUsage) when an output is also an input or another output, under any name, because the result would
/// silently replace a source or another result. Also throws when the name of an output holds a control character. Empty
/// names mean no file.
void check_paths_differ(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

/// Resolves `path`, which `file` gives relative to its own folder. An empty path stays empty (no file).
std::string path_beside(const std::string& file, const std::string& path);

/// Returns the same name for all names of a file. The file does not need to exist yet.
std::string canonical_name(const std::string& path);

/// Creates a folder and its parent folders if they are missing. Throws Error(kEnvironment) if this fails, and
/// Error(kUsage) for a new name that holds a control character.
void make_folder(const std::string& path);

/// Records the folders that make_folder() creates during the object's life; its destructor removes the empty ones.
/// Every command has such an object, so that a command that rejects its input leaves no folder.
class NewFolders {
 public:
  NewFolders();
  ~NewFolders();
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;
};

/// Returns the longest existing part of the folder that contains, or would contain, `path`.
std::string existing_part(const std::string& path);

/// Throws Error(kEnvironment, or kUsage for a folder or a control character) when no file of this name can be written.
/// Leaves no file.
void check_writable(const std::string& path);

}  // namespace multum
