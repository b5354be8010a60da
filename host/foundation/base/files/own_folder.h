// SPDX-License-Identifier: Apache-2.0
// Opens folders that only this user may write to, and empties them through their descriptors. Other users can often
// write to the folders of outputs. A name that was free a moment ago can now be a link, so no name is trusted twice.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/foundation/base/files/open_file.h"

namespace multum {

/// Longest name of a file that this program writes, in bytes. File systems allow 255, and names of temporary files and
/// hidden folders next to an output contain the output's name.
constexpr std::size_t kOutputNameMax = 200;

/// Throws Error(kUsage) if `name` is longer than kOutputNameMax; messages show `path`.
void check_name_length(const std::string& path, const std::string& name);

/// A file's name, and its opened folder. Links to the folder are followed, because users may name folders by links.
struct NamedPlace {
  OpenFile folder;
  std::string name;
};
/// Throws Error(kEnvironment) when the folder of `path` is missing or cannot be opened, and Error(kUsage) for a name
/// that is too long.
NamedPlace open_place(const std::string& path);

// A private working folder, created with mode 0700 and marked as multum's own. An existing folder must be marked or
// empty, belong to this user, be writable only by this user, be on the same device as the folder above, and not be a
// link. Mounts that give all files one owner or one mode (FAT, other systems' shares, NFS that squashes root) are
// detected with a file created for this purpose.
//
//   FOLDER/.multum-folder    the mark; without it, a user who may rename folders could make multum empty another folder

/// Opens the folder `name` of `above`, and creates it if it is missing. Does not mark it yet. If it is not an own
/// folder, leaves it unchanged and throws Error(kEnvironment), which names the obstacle. Messages show `path`.
OpenFile open_own_folder(const OpenFile& above, const std::string& name, const std::string& path);
/// Marks an empty folder. Returns false if another process has removed the folder. Throws Error(kEnvironment) for a
/// folder that is not empty and has no mark.
bool mark_own_folder(const OpenFile& folder, const std::string& path);
/// Opens the folder `name` of `above` if it is an own folder; the result is not open if there is no such folder. Throws
/// like open_own_folder() and mark_own_folder().
OpenFile find_own_folder(const OpenFile& above, const std::string& name, const std::string& path);
/// Removes the contents of an own folder, except for its mark and `kept`. Returns false like remove_entry().
bool clear_own_folder(const OpenFile& folder, const std::string& kept = "");
/// Removes the own folder that is open as `folder` and has the name `name` in `above`. Returns false like
/// remove_entry().
bool remove_own_folder(const OpenFile& above, const std::string& name, const OpenFile& folder);

/// Returns whether `name` in `folder` still names the file that is open as `descriptor`, and is not a link.
bool is_named(const OpenFile& folder, const std::string& name, int descriptor);

/// Returns the names in an open folder, except for "." and "..". Messages show `path`. Throws Error(kEnvironment).
std::vector<std::string> names_in(const OpenFile& folder, const std::string& path);

/// Removes a file, a link, or a folder with its contents. Follows no links, and does not touch other devices that are
/// mounted below. Returns false if anything could not be removed.
bool remove_entry(const OpenFile& folder, const std::string& name);

/// Returns 64 random bits from the system as 16 hexadecimal digits, for names that nobody can guess.
std::string random_digits();

}  // namespace multum
