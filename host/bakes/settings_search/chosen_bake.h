// SPDX-License-Identifier: Apache-2.0
// Bakes a map to a target and finds its settings: the cheapest that come within an error, or the most accurate within a
// time. They are chosen on a mosaic of the map (host/bakes/settings_search/setting_choice.h); then the whole map is
// baked and measured, and where that says otherwise, the next settings are baked. Whether an error is met is said by a
// second sample of footprints: of many settings, the one whose sample happens to be good is the one that is chosen.
#pragma once

#include <optional>
#include <string>

#include "host/bakes/settings_search/plane_picture.h"
#include "host/bakes/settings_search/setting_choice.h"

namespace multum {

/// One of both is set.
struct BakeTarget {
  std::optional<double> error;    // relative L1 for `brdf`, 0.1 = 10 %
  std::optional<double> seconds;  // of the bake: reading, fitting and writing, without choosing and measuring
  TargetBrdf brdf;
  std::optional<Representation> only;  // of these settings alone
  bool best_effort = false;            // write the best that was reached, too, where nothing reaches the target
  PlaneViewer viewer;                  // draws a picture of what was chosen; empty: none does
};

struct ChosenBake {
  BakeReport report;    // of the bake that was written; of the best one where none was
  std::string options;  // what was chosen, as `multum bake` takes it
  // Of the whole map. Where the target is an error: by footprints that had no part in the choice, if the others met it.
  ReachedError reached;
  bool met = false;
  bool written = false;
};

/// Throws Error(kUsage) for a target out of range or that does not go with the job.
void check_target(const BakeTarget& target, const BakeJob& job);

/// "an error of 0.1 for ggx:0.4", "a bake of 500 ms for lambert by vmf".
std::string target_text(const BakeTarget& target);
/// The same, and a hash of all else that is said of the job: the same for the same file. Throws
/// Error(kInput) when one of its maps cannot be read.
std::string target_key(const BakeJob& job, const BakeTarget& target);

/// JOB's own representation, lobes, order and effort do not count. JOB.output appears when the target is met, or with
/// `best_effort`. A file that was chosen for the same target, from the same source, is left as it is
/// (BakeReport::unchanged), unless JOB.force. Throws as bake_file() does.
ChosenBake bake_to_target(const BakeJob& job, const BakeTarget& target, Device& device, Progress* progress);
/// The same of what read_bake_source() has read of the job already; null: it is read here.
ChosenBake bake_to_target(const BakeJob& job, const BakeTarget& target, const BakeSource* source, Device& device,
                          Progress* progress);

}  // namespace multum
