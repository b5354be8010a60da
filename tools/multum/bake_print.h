// SPDX-License-Identifier: Apache-2.0
// Prints what `multum bake` did to a map.
#pragma once

#include <cstdio>

#include "host/bakes/bake/bake_job.h"

namespace multum {

struct BakePrinting {
  bool quiet = false;
  bool details = false;  // times of levels, launches, the plan
  std::FILE* out = stdout;
};

void print_report(const BakeJob& job, const BakePrinting& printing, const BakeReport& report);

}  // namespace multum
