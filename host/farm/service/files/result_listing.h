// SPDX-License-Identifier: Apache-2.0
// When a folder is published, its files are listed in the folder's file .multum-result, one line per file. Only files
// that are still unchanged may be removed for the next result of that name. Files that a person has added or changed
// are kept. All accesses are relative to the folder's own descriptor. A sub-folder that has been replaced by a symbolic
// link is therefore not followed.
//
// Any user who has write permission in the folder can write a listing too. Therefore the last line of a listing proves
// that the service wrote it. This line has the word "seal" and a code with the service's key (HMAC, SHA-256) over the
// folder's inode and the preceding lines.
#pragma once

#include <map>
#include <string>

#include "host/farm/service/files/result_seal.h"
#include "host/foundation/base/files/open_file.h"

namespace multum {

/// The file name of the listing.
inline constexpr char kResultListingName[] = ".multum-result";

/// Writes and syncs the listing of a folder's files, and removes remaining temporary files (AtomicFile). Throws
/// Error(kEnvironment).
void write_result_listing(const std::string& folder, const ResultSeal& seal);

/// Returns the name of the first entry that differs from the published folder. Returns "" if no entry differs, or if
/// the folder is empty. A folder without a listing by the service was never published. Throws Error(kEnvironment) when
/// this cannot be determined.
std::string unlisted_in(const std::string& folder, const ResultSeal& seal);

/// Returns whether the folder was published and still has exactly its published files. Throws like the function above.
bool is_as_published(const std::string& folder, const ResultSeal& seal);

/// Removes listed files that are unchanged, and then empty folders. Returns false if anything remains. Throws like the
/// functions above.
bool remove_listed(const std::string& folder, const ResultSeal& seal);

/// Returns the size of the listing in an open folder, or 0 if there is none.
std::size_t listing_bytes(const OpenFile& folder);

/// The listed files. The value is "BYTES NANOSECONDS", and the key is the name below the folder.
using PublishedFiles = std::map<std::string, std::string>;
/// Returns the published files of an open folder, or an empty list if nothing was ever published. Messages show `path`.
/// Throws Error(kEnvironment).
PublishedFiles published_files(const OpenFile& folder, const std::string& path, const ResultSeal& seal);
/// Opens a published file for reading. The file is beneath the folder, and symbolic links are not followed. Throws
/// Error(kUsage) when it no longer exists or has changed.
OpenFile open_published(const OpenFile& folder, const std::string& name, const std::string& state);
/// Returns whether an open file still has this state.
bool is_in_state(const OpenFile& file, const std::string& state);

}  // namespace multum
