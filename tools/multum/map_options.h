// SPDX-License-Identifier: Apache-2.0
// The options of `multum bake` that say how one map is read, fitted and stored; a manifest has them for each map.
#pragma once

#include <CLI/CLI.hpp>

#include "host/bake/map_options.h"

namespace multum {

/// --help shows them under this heading; no other option has it.
constexpr char kMapOptionGroup[] = "Options of a map";

void add_map_options(CLI::App& bake, MapOptions& options);

}  // namespace multum
