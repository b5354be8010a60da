// SPDX-License-Identifier: Apache-2.0
// Runs `multum bake --manifest`, which bakes the maps of a project and checks them for a build pipeline
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
  std::string manifest;  // manifest file; empty if the command runs in another mode
  ManifestRunSettings run;
  std::string junit;    // JUnit XML file; empty if none is written
  std::string summary;  // file of the summary; empty if none is written; "-" for stdout, to which no other text is then
                        // printed
  WorkShard shard;      // share of the maps
};

void add_manifest_options(CLI::App& bake, ManifestModeOptions& options);

/// Throws Error(kUsage) if an option of `bake` is given that the manifest sets for each map.
void check_no_map_is_given(const CLI::App& bake, const ManifestModeOptions& options);

/// Returns the exit code. `pattern` holds the settings that all maps share.
int run_manifest(const ManifestModeOptions& options, const BakeJob& pattern, const DeviceChoice& device,
                 const CommonOptions& common, BakePrinting printing);

}  // namespace multum
