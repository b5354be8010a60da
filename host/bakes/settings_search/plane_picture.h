// SPDX-License-Identifier: Apache-2.0
// Draws a baked file as multum-view does, a plane that runs to the horizon, and compares it with its reference: the
// error of a picture, beside that of pixels which the bake measures (host/bakes/accuracy/footprint_error.h).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/bakes/bake/bake_job.h"
#include "host/bakes/settings_search/setting_choice.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct PlaneViewer {
  std::string program;           // multum-view; empty: nothing is drawn
  std::string context = "auto";  // its options
  std::string decode = "child";
  int samples = 256;  // a pixel of the reference, which is the pixel's own
};

/// The baked map's own row of what multum-view --report wrote. Throws Error(kEnvironment) where there is none.
const nlohmann::json& own_picture(const nlohmann::json& report);

/// Relative L1 of the picture of JOB.output beside the reference that JOB.input gives. Throws Error(kEnvironment) where
/// nothing can be drawn, Cancelled. Files beside JOB.output come and go.
double draw_plane(const BakeJob& job, const TargetBrdf& brdf, const PlaneViewer& viewer, Progress* progress);

}  // namespace multum
