// SPDX-License-Identifier: Apache-2.0
// Checks a baked file of any representation by itself, without its source.
#pragma once

#include <string>
#include <vector>

namespace multum {

struct VerifyFinding {
  std::string check;  // "finite", "sum of a", ...
  bool passed;
  std::string detail;  // what was found, where, and what was expected
};

/// verify_movmf(), verify_moments(), verify_sh() or verify_pyramid(), by what the file says it is. Throws Error(kInput)
/// when it cannot be read at all.
std::vector<VerifyFinding> verify_baked(const std::string& path, int threads);

}  // namespace multum
