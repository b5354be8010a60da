// SPDX-License-Identifier: Apache-2.0
// Runs `multum bake --manifest`: all maps of a project, and the check that a build pipeline runs
// (docs/reference/manifests.md).
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "host/bakes/bake/bake_job.h"
#include "host/bakes/manifest/manifest_run.h"
#include "host/foundation/base/work_shard.h"
#include "tools/multum/bake_print.h"
#include "tools/multum/commands.h"

namespace multum {

struct ManifestModeOptions {
  std::string manifest;  // empty: the mode is not asked for
  ManifestRunSettings run;
  std::string junit;    // empty: none
  std::string summary;  // empty: none; "-": to stdout, and nothing else goes there
  WorkShard shard;      // of the maps
};

void add_manifest_options(CLI::App& bake, ManifestModeOptions& options);

/// Throws Error(kUsage) for an option of `bake` that was given and that the manifest has for each map.
void check_no_map_is_given(const CLI::App& bake, const ManifestModeOptions& options);

/// Returns the exit code. `pattern` has what is the same for all maps.
int run_manifest(const ManifestModeOptions& options, const BakeJob& pattern, const DeviceChoice& device,
                 const CommonOptions& common, BakePrinting printing);

}  // namespace multum
