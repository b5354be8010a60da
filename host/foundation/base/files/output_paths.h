// SPDX-License-Identifier: Apache-2.0
// Finds and checks the names of files before any work is done for them.
#pragma once

#include <string>
#include <vector>

namespace multum {

/// Throws Error(kUsage) when an output is also an input or another output, by whatever name: a result that takes the
/// place of a source, or of another result, would lose it without a word. Empty names stand for no file. Also where an
/// output's name holds a control character.
void check_paths_differ(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

/// `path` as `file` names it, relative to the folder of `file`; empty stays empty: no file.
std::string path_beside(const std::string& file, const std::string& path);

/// The one name of a file that may not be there yet, by whatever name it was given.
std::string canonical_name(const std::string& path);

/// Makes a folder, and those that it lies in, where it is not there yet. Throws Error(kEnvironment), and Error(kUsage)
/// for a new name that holds a control character.
void make_folder(const std::string& path);

/// While it lives, the folders that make_folder() makes are remembered; those that are empty when it ends go away
/// again. Every command has one, so that a command that refuses its input leaves no folder.
class NewFolders {
 public:
  NewFolders();
  ~NewFolders();
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;
};

/// The folder that `path` is or would lie in, as far as it is there.
std::string existing_part(const std::string& path);

/// Throws Error(kEnvironment, or kUsage for a folder or a control character) when no file of this name can be written;
/// creates none.
void check_writable(const std::string& path);

}  // namespace multum
