// SPDX-License-Identifier: Apache-2.0
// Lists what a folder held when it was published: .multum-result in it, a line a file. Only what is still so may be
// removed for the next result of that name; whatever a person has put there, or changed, stays. All is done beneath the
// folder's own descriptor: a sub-folder that becomes a link meanwhile leads nowhere.
//
// Whoever may write to the folder may write a listing too. Its last line, "seal" and a code by the service's key (HMAC,
// SHA-256) over the folder's inode and the lines before, says that it is the service's own.
#pragma once

#include <map>
#include <string>

#include "host/farm/service/files/result_seal.h"
#include "host/foundation/base/files/open_file.h"

namespace multum {

/// Name of the listing in its folder.
inline constexpr char kResultListingName[] = ".multum-result";

/// Writes and syncs the listing of a folder's files; temporary ones that are left there (AtomicFile) go. Throws
/// Error(kEnvironment).
void write_result_listing(const std::string& folder, const ResultSeal& seal);

/// Name of the first entry of the folder that is not as it was published; "": there is none, or the folder is empty. A
/// folder without a listing of the service's was not published at all. Throws Error(kEnvironment) when that cannot be
/// known.
std::string unlisted_in(const std::string& folder, const ResultSeal& seal);

/// Was the folder published, and does it hold what it held then, no more and no less? Throws likewise.
bool is_as_published(const std::string& folder, const ResultSeal& seal);

/// Removes what is listed and as it was, then what folders are empty. False: something is left. Throws likewise.
bool remove_listed(const std::string& folder, const ResultSeal& seal);

/// Bytes of the listing in an open folder; 0: it has none.
std::size_t listing_bytes(const OpenFile& folder);

/// A file as it is listed: "BYTES NANOSECONDS" by its name below the folder.
using PublishedFiles = std::map<std::string, std::string>;
/// Files that an open folder was published with; empty: it was not. `path` is for messages. Throws Error(kEnvironment).
PublishedFiles published_files(const OpenFile& folder, const std::string& path, const ResultSeal& seal);
/// Opens one of them for reading, beneath the folder and by no link. Throws Error(kUsage) when it is not there any more
/// or not as it was.
OpenFile open_published(const OpenFile& folder, const std::string& name, const std::string& state);
/// Is an open file still in that state?
bool is_in_state(const OpenFile& file, const std::string& state);

}  // namespace multum
