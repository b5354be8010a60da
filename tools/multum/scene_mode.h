// SPDX-License-Identifier: Apache-2.0
// Runs `multum bake scene.toml -o FOLDER`.
#pragma once

#include <optional>
#include <string>

#include "host/foundation/base/work_shard.h"
#include "tools/multum/bake_print.h"
#include "tools/multum/commands.h"

namespace multum {

/// Throws Error(kUsage) for options of one map: the scene names its maps.
void check_no_map_option_is_given(const CLI::App& bake, const std::string& scene);

/// Of the work: all of it, some shares, or what puts their results together.
struct SceneDivision {
  std::optional<WorkShard> shares;
  int merged_shards = 0;  // 0: none
};

/// `pattern` has what the command line says of every bake; its output is the folder. Returns the exit code.
int run_scene(const std::string& scene, BakeJob pattern, const DeviceChoice& device, const CommonOptions& common,
              const BakePrinting& printing, const SceneDivision& division);

}  // namespace multum
