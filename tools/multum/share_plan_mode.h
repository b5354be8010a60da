// SPDX-License-Identifier: Apache-2.0
// multum plan of one map: what its shares will take.
#pragma once

#include <string>

#include "host/foundation/parameters/parameter_values.h"

namespace multum {

struct SharePlanOptions {
  std::string input;
  ParameterValues values;      // of a bake
  int count = 0;               // of bands; 0: as many as take `share_seconds` each
  double share_seconds = 0.0;  // of processor time
  bool json = false;
};

/// Prints it. Throws Error.
int run_share_plan(const SharePlanOptions& options);

}  // namespace multum
