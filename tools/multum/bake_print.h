// SPDX-License-Identifier: Apache-2.0
// Prints the report of a bake as text or JSON.
#pragma once

#include <cstdio>

#include "host/bakes/bake/bake_job.h"
#include "tools/multum/json_output.h"

namespace multum {

struct BakePrinting {
  bool quiet = false;    // print no text; also set by --json
  bool details = false;  // also print the plan, level times and launches
  std::FILE* out = stdout;
  bool json = false;  // the command prints one JSON document at its end
};

void print_report(const BakeJob& job, const BakePrinting& printing, const BakeReport& report);

/// Returns the report that --json prints, which consists of "output" and the keys of --report.
OrderedJson bake_json(const BakeJob& job, const BakeReport& report);
/// Returns the entry of a map that failed, with "output", "source", and the reason in "failed".
OrderedJson failed_bake_json(const BakeJob& job, const std::string& error);

}  // namespace multum
