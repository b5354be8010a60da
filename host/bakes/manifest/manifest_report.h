// SPDX-License-Identifier: Apache-2.0
// Reports a run over a manifest to build services, as JUnit XML, Markdown, a list for a terminal, and an exit code.
#pragma once

#include <string>
#include <vector>

#include "host/bakes/manifest/manifest_run.h"

namespace multum {

struct ManifestOutcome {
  std::string manifest;  // path of the manifest, as given
  ManifestRunSettings settings;
  std::vector<MapResult> results;
  double seconds = 0.0;
};

/// Formats one line: "multum bake --check: passed, 3 maps in place", "... FAILED for 2 of 3 maps: 1 stale, 1 worse".
std::string manifest_verdict(const ManifestOutcome& outcome);

/// Formats the verdict and, below it, a line with the state, the name and the reason for each map that is not in place.
/// The text is empty if all maps are in place.
std::string manifest_failures(const ManifestOutcome& outcome);

/// Formats a test suite with one test case per map. <failure> marks findings of a check (missing, stale, damaged,
/// worse). <error> marks maps whose state is unknown because they failed.
std::string manifest_junit(const ManifestOutcome& outcome);

/// Formats the verdict, a table with one row per map, and the reasons why maps are not in place.
std::string manifest_summary(const ManifestOutcome& outcome);

/// Returns 0 if all maps are in place. If a map failed, the check is incomplete, and the exit code of the first such
/// map is returned (3 for input, 4 for environment). Otherwise returns 5.
int manifest_exit_code(const ManifestOutcome& outcome);

}  // namespace multum
