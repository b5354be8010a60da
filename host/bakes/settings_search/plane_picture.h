// SPDX-License-Identifier: Apache-2.0
// Draws a baked file with multum-view on a plane that extends to the horizon, and compares it with its reference. The
// error of this picture complements the pixel error that the bake measures (host/bakes/accuracy/footprint_error.h).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/bakes/bake/bake_job.h"
#include "host/bakes/settings_search/setting_choice.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct PlaneViewer {
  std::string program;           // multum-view; if empty, nothing is drawn
  std::string context = "auto";  // multum-view's options --context and --decode
  std::string decode = "child";
  int samples = 256;  // per pixel of the reference
};

/// Returns the baked map's row in the report of multum-view --report. Throws Error(kEnvironment) if the row is missing.
const nlohmann::json& own_picture(const nlohmann::json& report);

/// Returns the relative L1 error of a picture of JOB.output against the reference from JOB.input. Throws
/// Error(kEnvironment) if nothing can be drawn, and Cancelled. Writes temporary files next to JOB.output.
double draw_plane(const BakeJob& job, const TargetBrdf& brdf, const PlaneViewer& viewer, Progress* progress);

}  // namespace multum
