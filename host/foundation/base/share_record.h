// SPDX-License-Identifier: Apache-2.0
// Notes which files a share of a scene or of inference made, in OUTPUT/shards/3-of-8.shard. A merge reads the records
// of all shares, and a share that runs again its own.
//
//   {"multumShare": 1, "kind": "scene", "share": 3, "of": 8, "key": "...", "content": {...}}
//   SHA-256 of the first line, without its end
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace multum {

struct ShareName {
  std::string folder;  // of the output
  std::string kind;    // "scene" or "inference"
  int index = 1, count = 1;

  std::string path() const;
  /// ": --shard 3/8 makes it again"
  std::string remedy() const;
};

/// Appears whole. `key` stands for all that the share's files depend on. Throws Error(kEnvironment).
void write_share_record(const ShareName& share, const std::string& key, const nlohmann::json& content);

/// Throws Error(kEnvironment) that names the file, what is wrong with it and the option that makes it: not there,
/// damaged, of another share, or of another key.
nlohmann::json read_share_record(const ShareName& share, const std::string& key);

}  // namespace multum
