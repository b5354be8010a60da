// SPDX-License-Identifier: Apache-2.0
// Generates docs/contributing/STABILITY.md. For every numerical case, the page lists the failure without the guard, the
// guard, the bound, and the worst error.
#pragma once

#include <string>
#include <vector>

#include "host/lab/reference/numerical_case.h"

namespace multum {

/// Returns Markdown with one table per formula, in the order of the runs' cases.
std::string stability_page(const std::vector<NumericalRun>& runs);

/// Lists the names of the cases on a page, in the order of the page.
std::vector<std::string> cases_of_page(const std::string& page);

}  // namespace multum
