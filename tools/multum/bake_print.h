// SPDX-License-Identifier: Apache-2.0
// What `multum bake` says of a map that it has done.
#pragma once

#include <cstdio>

#include "host/bake/bake_job.h"

namespace multum {

struct BakePrinting {
  bool quiet = false;
  bool details = false;  // times of levels, launches, the plan
  std::FILE* out = stdout;
};

void print_report(const BakeJob& job, const BakePrinting& printing, const BakeReport& report);

}  // namespace multum
