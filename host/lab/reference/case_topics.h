// SPDX-License-Identifier: Apache-2.0
// Lists the numerical dangers of a bake or a picture, with the names of the cases that test each danger.
// docs/contributing/STABILITY.md begins with this list. If a danger has no test, add a case before you add the danger
// here.
#pragma once

#include <string>
#include <vector>

namespace multum {

struct CaseTopic {
  std::string danger;
  std::vector<std::string> cases;  // names of cases in host/lab/selftest and tests/gl; "HardCaseTest.X" is the name of
                                   // a whole bake in tests/hard_cases
};

const std::vector<CaseTopic>& case_topics();

}  // namespace multum
