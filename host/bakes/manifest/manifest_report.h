// SPDX-License-Identifier: Apache-2.0
// Reports a run over a manifest as build services show it: JUnit XML, Markdown, a list for a terminal, and the exit
// code.
#pragma once

#include <string>
#include <vector>

#include "host/bakes/manifest/manifest_run.h"

namespace multum {

struct ManifestOutcome {
  std::string manifest;  // its path as given
  ManifestRunSettings settings;
  std::vector<MapResult> results;
  double seconds = 0.0;
};

/// One line: "multum bake --check: passed, 3 maps in place", "... FAILED for 2 of 3 maps: 1 stale, 1 worse".
std::string manifest_verdict(const ManifestOutcome& outcome);

/// The verdict and, below it, a line for each map that is not in place: state, name, why. Empty when all are.
std::string manifest_failures(const ManifestOutcome& outcome);

/// A test suite with a test case a map: <failure> for what a check found (missing, stale, damaged, worse), <error> for
/// maps that failed, since nothing could be found out.
std::string manifest_junit(const ManifestOutcome& outcome);

/// The verdict, a table with a row a map, and why for those that are not in place.
std::string manifest_summary(const ManifestOutcome& outcome);

/// 0 when all are in place. Else that of the first map that failed (3 input, 4 environment), for of that map nothing is
/// known and the check is not whole; else 5.
int manifest_exit_code(const ManifestOutcome& outcome);

}  // namespace multum
