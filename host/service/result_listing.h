// SPDX-License-Identifier: Apache-2.0
// What a folder held when it was published: .multum-result in it, a line a file. Only what is still so may be removed
// for the next result of that name; whatever a person has put there, or changed, stays.
#pragma once

#include <string>

namespace multum {

/// Writes and syncs the listing of a folder's files. Throws Error(kEnvironment).
void write_result_listing(const std::string& folder);

/// What of the folder is not as it was published: its name; "": nothing, or the folder is empty. A folder without a
/// listing was not published at all. Throws Error(kEnvironment) when that cannot be known.
std::string unlisted_in(const std::string& folder);

/// Removes what is listed and as it was, then what folders are empty. False: something is left.
bool remove_listed(const std::string& folder);

}  // namespace multum
