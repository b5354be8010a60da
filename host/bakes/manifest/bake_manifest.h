// SPDX-License-Identifier: Apache-2.0
// Reads the list of a project's maps, how each is baked and how large its error may be, which a build pipeline keeps in
// place.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/bakes/settings_search/chosen_bake.h"

namespace multum {

struct ManifestMap {
  std::string name;  // the output as the manifest names it, with its tile where it is one of a set
  BakeJob job;
  std::optional<double> error_max;   // the largest measured error that is good enough, relative L1, above 0
  std::optional<BakeTarget> target;  // settings are chosen for this
};

/// Reads and validates a manifest; each map's job is `pattern` with what the manifest says. A set is as many maps as it
/// has tiles; one without any is one map still, whose input nobody will find. No other file is looked at. Throws
/// Error(kInput) that names the file, the line, what was found and what was expected.
std::vector<ManifestMap> read_bake_manifest(const std::string& path, const BakeJob& pattern);

}  // namespace multum
