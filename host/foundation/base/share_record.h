// SPDX-License-Identifier: Apache-2.0
// Lists the files that one share of a scene or of an inference made. The list is stored in the record
// OUTPUT/shards/3-of-8.shard. A merge reads the records of all shares. A share that runs again reads its own record.
//
//   {"multumShare": 1, "kind": "scene", "share": 3, "of": 8, "key": "...", "content": {...}}
//   SHA-256 of the first line, without its line end
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace multum {

struct ShareName {
  std::string folder;  // the output folder
  std::string kind;    // "scene" or "inference"
  int index = 1, count = 1;

  std::string path() const;
  /// Returns advice that names the share, such as ": --shard 3/8 makes it again".
  std::string remedy() const;
};

/// Writes a record atomically. `key` identifies all inputs on which the share's files depend. Throws
/// Error(kEnvironment).
void write_share_record(const ShareName& share, const std::string& key, const nlohmann::json& content);

/// Reads a record. If the record is missing or damaged, or belongs to another share or key, throws Error(kEnvironment).
/// The message names the file, the fault, and the option that makes the share again.
nlohmann::json read_share_record(const ShareName& share, const std::string& key);

}  // namespace multum
