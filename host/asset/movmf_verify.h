// SPDX-License-Identifier: Apache-2.0
// Checks a baked file by itself, without its source: structure, finite values, sums, checksum.
#pragma once

#include <string>
#include <vector>

#include "host/asset/movmf_mipmap.h"

namespace multum {

struct VerifyFinding {
  std::string check;  // "finite", "sum of a", ...
  bool passed;
  std::string detail;  // what was found, where, and what was expected
};

/// Throws Error(kInput) when the file cannot be read at all (structure); every other check is a finding.
std::vector<VerifyFinding> verify_movmf(const std::string& path, int threads);

}  // namespace multum
