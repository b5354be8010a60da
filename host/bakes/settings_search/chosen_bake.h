// SPDX-License-Identifier: Apache-2.0
// Bakes a map to a target and finds its settings: the cheapest within an error, or the most accurate within a time.
// Settings are chosen on a mosaic of the map (host/bakes/settings_search/setting_choice.h). Then the whole map is
// baked and measured, and if it misses the target, the next settings are baked. A second sample of footprints decides
// whether the target error is met, because among many settings the search prefers settings whose first sample is low by
// chance.
#pragma once

#include <optional>
#include <string>

#include "host/bakes/settings_search/plane_picture.h"
#include "host/bakes/settings_search/setting_choice.h"

namespace multum {

/// Either `error` or `seconds` is set.
struct BakeTarget {
  std::optional<double> error;    // relative L1 for `brdf`, 0.1 = 10 %
  std::optional<double> seconds;  // time of the bake: reading, fitting and writing, without choosing and measuring
  TargetBrdf brdf;
  std::optional<Representation> only;  // restricts the search
  bool best_effort = false;            // write the best result even if nothing reaches the target
  PlaneViewer viewer;                  // draws a picture of the result; empty for no picture
};

struct ChosenBake {
  BakeReport report;    // report of the written bake, or of the best bake if none was written
  std::string options;  // the chosen settings as options of `multum bake`
  // Error of the whole map. If the first footprints meet a target error, this error is from footprints that were not
  // used for the choice.
  ReachedError reached;
  bool met = false;
  bool written = false;
};

/// Throws Error(kUsage) for a target that is out of range or that does not fit the job.
void check_target(const BakeTarget& target, const BakeJob& job);

/// Describes a target: "an error of 0.1 for ggx:0.4", "a bake of 500 ms for lambert by vmf".
std::string target_text(const BakeTarget& target);
/// Returns target_text() and a hash of the job's other settings. Keys are equal for equal files. Throws Error(kInput)
/// if one of the maps cannot be read.
std::string target_key(const BakeJob& job, const BakeTarget& target);

/// Ignores JOB's representation, lobes, order and effort. JOB.output appears if the target is met, or with
/// `best_effort`. Keeps a file that was chosen for the same target from the same source (BakeReport::unchanged),
/// unless JOB.force. Throws as bake_file() does.
ChosenBake bake_to_target(const BakeJob& job, const BakeTarget& target, Device& device, Progress* progress);
/// Bakes from `source`, the result of read_bake_source() for the job; if null, reads it.
ChosenBake bake_to_target(const BakeJob& job, const BakeTarget& target, const BakeSource* source, Device& device,
                          Progress* progress);

}  // namespace multum
