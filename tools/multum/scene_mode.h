// SPDX-License-Identifier: Apache-2.0
// Runs `multum bake scene.toml -o FOLDER`.
#pragma once

#include <string>

#include "tools/multum/bake_print.h"
#include "tools/multum/commands.h"

namespace multum {

/// Throws Error(kUsage) for options of one map: the scene names its maps.
void check_no_map_option_is_given(const CLI::App& bake, const std::string& scene);

/// `pattern` has what the command line says of every bake; its output is the folder. Returns the exit code.
int run_scene(const std::string& scene, BakeJob pattern, const DeviceChoice& device, const CommonOptions& common,
              const BakePrinting& printing);

}  // namespace multum
