// SPDX-License-Identifier: Apache-2.0
// Records the files that the daemon made or may remove in the ledger. These are outputs, uploads, and files of purged
// jobs.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "host/farm/service/ledger/sqlite_database.h"

namespace multum {

/// Lists the files in the daemon's own folders that the ledger records. No other file in these folders may be removed.
/// The ledger stores paths as texts (path_text.h).
class FileNotes {
 public:
  explicit FileNotes(SqliteDatabase& database) : database_(database) {}

  struct LeftOver {
    std::int64_t job = 0;  // the purged job
    std::string output;    // output below LedgerSettings::results; "" if there is none
    std::string identity;  // identity of the published result; "" if unknown
  };
  /// Returns at most `limit` files of purged jobs whose numbers are above `after`, in ascending order.
  std::vector<LeftOver> left_overs(std::int64_t after, int limit);
  void forget_left_over(std::int64_t job);

  void note_upload(const std::string& path);
  /// Returns at most `limit` uploads, in the order of their paths, from the first one after the path `after`.
  std::vector<std::string> uploads(const std::string& after, int limit);
  void forget_upload(const std::string& path);

  /// Returns the folders that contain results of jobs or will contain them, without duplicates.
  std::vector<std::string> output_folders();
  /// Paths that jobs use.
  struct Uses {
    std::set<std::string> outputs;  // outputs of all jobs
    std::set<std::string> inputs;   // texts that begin with "/" in the parameters of unfinished jobs
    /// Returns whether a job names the path, a path below it, or a folder that contains it.
    bool have(const std::string& path) const;
  };
  Uses uses();

 private:
  SqliteDatabase& database_;
};

}  // namespace multum
