// SPDX-License-Identifier: Apache-2.0
// The folders of the machine that jobs may access.
#pragma once

#include "host/farm/service/files/result_seal.h"
#include "host/foundation/sandbox/path_roots.h"

namespace multum {

struct JobRoots {
  PathRoots inputs;   // the configured roots, uploads and results
  PathRoots outputs;  // the configured roots and results
  PathRoots results;  // the daemon's own place for results
  ResultSeal seal;    // seal of folders that the daemon publishes
};

}  // namespace multum
