// SPDX-License-Identifier: Apache-2.0
// Reads the list of maps that a build pipeline keeps up to date, with the settings and the largest allowed error of
// each.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/bakes/settings_search/chosen_bake.h"

namespace multum {

struct ManifestMap {
  std::string name;  // the output's name in the manifest, including the tile number if the map is a tile of a set
  BakeJob job;
  std::optional<double> error_max;   // the largest allowed error, relative L1, above 0
  std::optional<BakeTarget> target;  // target for which settings are chosen
};

/// Reads and validates a manifest. Each map's job is `pattern` with the manifest's values. A UDIM set becomes one map
/// per tile. A set without tiles becomes one map, whose input does not exist. Reads no file except the manifest. Throws
/// Error(kInput) that names the file, the line, the value found and the value expected.
std::vector<ManifestMap> read_bake_manifest(const std::string& path, const BakeJob& pattern);

}  // namespace multum
