// SPDX-License-Identifier: Apache-2.0
// Opens folders that this user alone may write to, and empties them beneath their descriptors. Outputs often lie where
// other users may write too: a name that was free a moment ago may be a link by now, so no name is trusted twice.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/foundation/base/files/open_file.h"

namespace multum {

/// Longest name of a file that this program writes, in bytes. File systems allow 255, and names of temporary files and
/// hidden folders next to an output contain the output's name.
constexpr std::size_t kOutputNameMax = 200;

/// Throws Error(kUsage) for a `name` that is longer than kOutputNameMax; `path` is for the message.
void check_name_length(const std::string& path, const std::string& name);

/// A file's name, and the folder that it lies in, opened. A link to that folder is followed: users name folders so.
struct NamedPlace {
  OpenFile folder;
  std::string name;
};
/// Throws Error(kEnvironment) when the folder of `path` is missing or cannot be opened; kUsage for a name that is too
/// long.
NamedPlace open_place(const std::string& path);

// A folder of its own for work: made with mode 0700, and marked. One that is there already is taken as ours when it is
// a folder, reached by no link, on the same device as the folder above, that belongs to this user, that nobody else may
// write to, and that is marked or empty. Mounts that give all files one owner or one mode (FAT, other systems' shares,
// NFS that squashes root) are known by a file made for the purpose.
//
//   FOLDER/.multum-folder    the mark: who may rename folders could have another one of ours emptied otherwise.

/// The folder `name` of `above`, made if it is missing; not marked yet. Throws Error(kEnvironment) for what is not
/// ours, names what was found, and leaves it alone. `path` is for messages.
OpenFile open_own_folder(const OpenFile& above, const std::string& name, const std::string& path);
/// Marks an empty folder. False: it was removed meanwhile. Throws Error(kEnvironment) for one that holds anything and
/// has no mark.
bool mark_own_folder(const OpenFile& folder, const std::string& path);
/// The folder `name` of `above`, if it is ours; not open where there is none. Throws as the two above do.
OpenFile find_own_folder(const OpenFile& above, const std::string& name, const std::string& path);
/// Removes what is in an own folder but for its mark and `kept`. False as remove_entry().
bool clear_own_folder(const OpenFile& folder, const std::string& kept = "");
/// Removes the own folder that `folder` has open and that is `name` of `above`. False as remove_entry().
bool remove_own_folder(const OpenFile& above, const std::string& name, const OpenFile& folder);

/// Does `name` in `folder` still lead to what `descriptor` has open, by no link?
bool is_named(const OpenFile& folder, const std::string& name, int descriptor);

/// Names in an open folder, but for "." and "..". `path` is for messages. Throws Error(kEnvironment).
std::vector<std::string> names_in(const OpenFile& folder, const std::string& path);

/// Removes a folder of this name and all in it, or a file or link of this name. Follows no link, and leaves other
/// devices that are mounted below. False: something could not be removed.
bool remove_entry(const OpenFile& folder, const std::string& name);

/// 64 random bits of the system, as 16 hexadecimal digits: part of names that nobody can guess.
std::string random_digits();

}  // namespace multum
