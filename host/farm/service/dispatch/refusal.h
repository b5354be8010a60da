// SPDX-License-Identifier: Apache-2.0
// Why a client is not served.
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
