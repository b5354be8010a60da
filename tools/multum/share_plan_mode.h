// SPDX-License-Identifier: Apache-2.0
// Runs `multum plan` for one map. This command predicts the times of the map's shares.
#pragma once

#include <string>

#include "host/foundation/parameters/parameter_values.h"

namespace multum {

struct SharePlanOptions {
  std::string input;
  ParameterValues values;      // values of a bake
  int count = 0;               // number of bands; if 0, the number is chosen so that each band takes `share_seconds`
  double share_seconds = 0.0;  // processor time per band
  bool json = false;
};

/// Prints the plan. Throws Error.
int run_share_plan(const SharePlanOptions& options);

}  // namespace multum
