// SPDX-License-Identifier: Apache-2.0
// What a folder held when it was published: .multum-result in it, a line a file. Only what is still so may be removed
// for the next result of that name; whatever a person has put there, or changed, stays. All is done beneath the
// folder's own descriptor: a sub-folder that becomes a link meanwhile leads nowhere.
#pragma once

#include <string>

namespace multum {

/// Writes and syncs the listing of a folder's files. Throws Error(kEnvironment).
void write_result_listing(const std::string& folder);

/// What of the folder is not as it was published, the first that is found: its name; "": nothing, or the folder is
/// empty. A folder without a listing was not published at all. Throws Error(kEnvironment) when that cannot be known.
std::string unlisted_in(const std::string& folder);

/// Whether the folder was published, and holds what it held then: no more, no less. Throws likewise.
bool is_as_published(const std::string& folder);

/// Removes what is listed and as it was, then what folders are empty. False: something is left. Throws likewise.
bool remove_listed(const std::string& folder);

}  // namespace multum
