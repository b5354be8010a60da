// SPDX-License-Identifier: Apache-2.0
// docs/contributing/STABILITY.md: every numerical case with what happens without its guard, the guard, the bound and
// the worst error seen.
#pragma once

#include <string>
#include <vector>

#include "host/lab/reference/numerical_case.h"

namespace multum {

/// Markdown: one table a formula, in the order of the runs' cases.
std::string stability_page(const std::vector<NumericalRun>& runs);

/// The names of the cases that a page has, in its order.
std::vector<std::string> cases_of_page(const std::string& page);

}  // namespace multum
