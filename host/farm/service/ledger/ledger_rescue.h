// SPDX-License-Identifier: Apache-2.0
// Rescues the readable part of a damaged ledger into a new one. Reads every table one row at a time: forwards,
// backwards, and by row number in between. If a page is damaged, only the rows in this page are lost. If the page with
// the list of tables is lost, the page of a new ledger replaces it, because all ledgers have the same layout.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace multum {

struct RescueReport {
  struct Table {
    std::string name;
    std::int64_t saved = 0;
    std::int64_t damaged = 0;  // rows (or whole jobs, if rows belong to one job) that were found but not saved
  };
  std::vector<Table> tables;
  std::string kept;  // path of the old ledger
};

/// Replaces DATA/jobs.sqlite by a new ledger. The old ledger is kept next to it under another name. Throws
/// Error(kEnvironment) while a daemon runs there, and Error(kInput) when nothing can be read. In both cases, nothing is
/// changed.
RescueReport rescue_ledger(const std::string& data);

}  // namespace multum
