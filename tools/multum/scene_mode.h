// SPDX-License-Identifier: Apache-2.0
// Runs `multum bake scene.toml -o FOLDER`.
#pragma once

#include <optional>
#include <string>

#include "host/foundation/base/work_shard.h"
#include "tools/multum/bake_print.h"
#include "tools/multum/commands.h"

namespace multum {

/// Throws Error(kUsage) for options of one map, because the scene sets them for its maps.
void check_no_map_option_is_given(const CLI::App& bake, const std::string& scene);

/// The part of a bake to run, which is everything, some shares, or the merge of all shares.
struct SceneDivision {
  std::optional<WorkShard> shares;
  int merged_shards = 0;  // 0 if no shares are merged
};

/// `pattern` holds the settings that the command line gives to every map. Its output is a folder. Returns the exit
/// code.
int run_scene(const std::string& scene, BakeJob pattern, const DeviceChoice& device, const CommonOptions& common,
              const BakePrinting& printing, const SceneDivision& division);

}  // namespace multum
