// SPDX-License-Identifier: Apache-2.0
// Prints the report of a bake as text or JSON.
#pragma once

#include <cstdio>

#include "host/bakes/bake/bake_job.h"
#include "tools/multum/json_output.h"

namespace multum {

struct BakePrinting {
  bool quiet = false;    // print no text; also with --json
  bool details = false;  // print the plan, times of levels and launches too
  std::FILE* out = stdout;
  bool json = false;  // the command prints a document at its end
};

void print_report(const BakeJob& job, const BakePrinting& printing, const BakeReport& report);

/// The report as --json prints it: "output", then the keys of --report.
OrderedJson bake_json(const BakeJob& job, const BakeReport& report);
/// The entry of a map that failed: "output", "source", and why in "failed".
OrderedJson failed_bake_json(const BakeJob& job, const std::string& error);

}  // namespace multum
