// SPDX-License-Identifier: Apache-2.0
// Opens folders that only this user may write to, and empties them through their descriptors. Other users can often
// write to the output folders. A name that was free a moment ago can now be a link, so a name is never trusted twice.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/foundation/base/files/open_file.h"

namespace multum {

/// The longest name, in bytes, of a file that this program writes. File systems allow 255 bytes, but the names of
/// temporary files and of hidden folders next to an output contain the name of the output.
constexpr std::size_t kOutputNameMax = 200;

/// Throws Error(kUsage) if `name` is longer than kOutputNameMax; messages show `path`.
void check_name_length(const std::string& path, const std::string& name);

/// The name of a file, and its folder, which has been opened. Links to the folder are followed, because users may name
/// folders by links.
struct NamedPlace {
  OpenFile folder;
  std::string name;
};
/// Throws Error(kEnvironment) when the folder of `path` is missing or cannot be opened, and Error(kUsage) for a name
/// that is too long.
NamedPlace open_place(const std::string& path);

// A private working folder, created with mode 0700 and marked as a folder of multum. An existing folder must be marked
// or empty, belong to this user, be writable only by this user, be on the same device as the folder above, and not be a
// link. Some mounts give all files one owner or one mode (FAT, shares of other systems, NFS that squashes root). Such
// mounts are detected with a file created for this purpose.
//
//   FOLDER/.multum-folder    the mark; without it, a user who may rename folders could make multum empty another folder

/// Opens the folder `name` of `above`, and creates it if it is missing. Does not mark it yet. If the existing folder is
/// not an own folder, leaves it unchanged and throws Error(kEnvironment), which gives the reason. Messages show `path`.
OpenFile open_own_folder(const OpenFile& above, const std::string& name, const std::string& path);
/// Marks an empty folder. Returns false if another process has removed the folder. Throws Error(kEnvironment) for a
/// folder that is not empty and has no mark.
bool mark_own_folder(const OpenFile& folder, const std::string& path);
/// Opens the folder `name` of `above` if it is an own folder. The result is not open if there is no such folder. Throws
/// like open_own_folder() and mark_own_folder().
OpenFile find_own_folder(const OpenFile& above, const std::string& name, const std::string& path);
/// Removes the contents of an own folder, except for its mark and `kept`. Returns false like remove_entry().
bool clear_own_folder(const OpenFile& folder, const std::string& kept = "");
/// Removes the own folder that is open as `folder` and is called `name` in `above`. Returns false like remove_entry().
bool remove_own_folder(const OpenFile& above, const std::string& name, const OpenFile& folder);

/// Returns whether `name` in `folder` still names the file that is open as `descriptor`. A link does not count.
bool is_named(const OpenFile& folder, const std::string& name, int descriptor);

/// Returns the names in an open folder, except for "." and "..". Messages show `path`. Throws Error(kEnvironment).
std::vector<std::string> names_in(const OpenFile& folder, const std::string& path);

/// Removes a file, a link, or a folder with its contents. Does not follow links, and does not touch other devices that
/// are mounted below the folder. Returns false if anything could not be removed.
bool remove_entry(const OpenFile& folder, const std::string& name);

/// Returns 64 random bits from the system as 16 hexadecimal digits, for names that nobody can guess.
std::string random_digits();

}  // namespace multum
