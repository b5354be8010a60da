// SPDX-License-Identifier: Apache-2.0
// Finds settings with which a map meets a target, and bakes the map with these settings. For a target error, the
// cheapest settings are chosen. For a target time, the most accurate settings are chosen. Settings are chosen on a
// mosaic of the map (host/bakes/settings_search/setting_choice.h). Then the whole map is baked and measured. If it
// misses the target, the next settings are tried. A second sample of footprints decides whether the target error is
// met, because the search favours settings whose error in the first sample is low by chance.
#pragma once

#include <optional>
#include <string>

#include "host/bakes/settings_search/plane_picture.h"
#include "host/bakes/settings_search/setting_choice.h"

namespace multum {

/// Exactly one of `error` and `seconds` is set.
struct BakeTarget {
  std::optional<double> error;    // relative L1 error for `brdf` (0.1 is 10 %)
  std::optional<double> seconds;  // time for reading, fitting and writing, but not for choosing and measuring
  TargetBrdf brdf;
  std::optional<Representation> only;  // restricts the search to one representation
  bool best_effort = false;            // write the best result even if no settings reach the target
  PlaneViewer viewer;                  // draws a picture of the result; empty for no picture
};

struct ChosenBake {
  BakeReport report;    // report of the written bake, or of the best bake if none was written
  std::string options;  // the chosen settings as options of `multum bake`
  // The error of the whole map. If the error at the first footprints meets the target, this is the error at footprints
  // that were not used for the choice.
  ReachedError reached;
  bool met = false;
  bool written = false;
};

/// Throws Error(kUsage) for a target that is out of range or that does not fit the job.
void check_target(const BakeTarget& target, const BakeJob& job);

/// Describes a target, as in "an error of 0.1 for ggx:0.4" or "a bake of 500 ms for lambert by vmf".
std::string target_text(const BakeTarget& target);
/// Returns target_text() and a hash of the job's other settings. The keys of two jobs are equal if their files would be
/// equal. Throws Error(kInput) if one of the maps cannot be read.
std::string target_key(const BakeJob& job, const BakeTarget& target);

/// Ignores JOB's representation, lobes, order and effort. JOB.output appears if the target is met or `best_effort` is
/// set. Keeps an existing file that was chosen for the same target and baked from the same source
/// (BakeReport::unchanged), unless JOB.force is set. Throws the same errors as bake_file().
ChosenBake bake_to_target(const BakeJob& job, const BakeTarget& target, Device& device, Progress* progress);
/// Bakes from `source`, the result of read_bake_source() for the job. If `source` is null, reads it.
ChosenBake bake_to_target(const BakeJob& job, const BakeTarget& target, const BakeSource* source, Device& device,
                          Progress* progress);

}  // namespace multum
