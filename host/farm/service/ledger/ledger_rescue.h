// SPDX-License-Identifier: Apache-2.0
// Rescues what can be read of a damaged ledger into a new one: row by row, from both ends of each table and between by
// number, so that a damaged page costs the rows on it alone. Where the page that lists the tables is lost, a new
// ledger's is taken: all are laid out alike.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace multum {

struct RescueReport {
  struct Table {
    std::string name;
    std::int64_t saved = 0;
    std::int64_t damaged = 0;  // rows, or for those of one job the job, that were seen and not saved
  };
  std::vector<Table> tables;
  std::string kept;  // where the ledger before is
};

/// Puts a new ledger in the place of DATA/jobs.sqlite, which is kept beside it under another name. Throws
/// Error(kEnvironment) while a daemon is at work there, Error(kInput) when nothing can be read: then all is as before.
RescueReport rescue_ledger(const std::string& data);

}  // namespace multum
