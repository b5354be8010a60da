// SPDX-License-Identifier: Apache-2.0
// Notes in the ledger of files that the daemon made or may remove: outputs, uploads, what purged jobs left.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "host/farm/service/ledger/sqlite_database.h"

namespace multum {

/// Lists what lies in the daemon's own folders because of a ledger: nothing else there may be removed. Paths are
/// texts in the ledger (path_text.h).
class FileNotes {
 public:
  explicit FileNotes(SqliteDatabase& database) : database_(database) {}

  struct LeftOver {
    std::int64_t job = 0;  // that was purged
    std::string output;    // below LedgerSettings::results; "": it had none there
    std::string identity;  // of what it put there; "": nothing, as far as is known
  };
  /// At most `limit` of them, of jobs above `after`, in order.
  std::vector<LeftOver> left_overs(std::int64_t after, int limit);
  void forget_left_over(std::int64_t job);

  void note_upload(const std::string& path);
  /// At most `limit` of them, behind the path `after`, in order.
  std::vector<std::string> uploads(const std::string& after, int limit);
  void forget_upload(const std::string& path);

  /// Folders that hold results of jobs or will, each once.
  std::vector<std::string> output_folders();
  /// Paths that jobs have a use for.
  struct Uses {
    std::set<std::string> outputs;  // of all jobs
    std::set<std::string> inputs;   // texts in the parameters of unfinished jobs that begin with "/"
    /// Whether a job names the path, anything below it, or a folder that it lies in.
    bool have(const std::string& path) const;
  };
  Uses uses();

 private:
  SqliteDatabase& database_;
};

}  // namespace multum
