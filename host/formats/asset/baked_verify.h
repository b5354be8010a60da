// SPDX-License-Identifier: Apache-2.0
// Checks a baked file of any representation without its source.
#pragma once

#include <string>
#include <vector>

namespace multum {

struct VerifyFinding {
  std::string check;  // name of the check, such as "finite" or "sum of a"
  bool passed;
  std::string detail;  // the value found, its place, and the expected value
};

/// Calls verify_movmf(), verify_moments(), verify_sh() or verify_pyramid(), according to the file's header. Throws
/// Error(kInput) if the file cannot be read at all.
std::vector<VerifyFinding> verify_baked(const std::string& path, int threads);

}  // namespace multum
