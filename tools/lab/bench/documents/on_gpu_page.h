// SPDX-License-Identifier: Apache-2.0
// Makes the page of a run of `multum-bench on-gpu`. The page lists the devices, the results of the steps, and the
// failures.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace multum::bench {

/// Returns Markdown. Omits sections of steps that did not run.
std::string page_of_run(const nlohmann::ordered_json& result);

}  // namespace multum::bench
