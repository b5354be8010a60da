// SPDX-License-Identifier: Apache-2.0
// The reason why a request is refused.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace multum {

struct Refusal {
  int status;
  std::string code, message;
  std::vector<std::pair<std::string, std::string>> headers = {};
};

}  // namespace multum
