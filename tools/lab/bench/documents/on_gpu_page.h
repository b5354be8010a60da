// SPDX-License-Identifier: Apache-2.0
// The page of a run of `multum-bench on-gpu`: what the machine has, what each step gave, and what could not be done.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace multum::bench {

/// Markdown. Sections of steps that are not there are left out.
std::string page_of_run(const nlohmann::ordered_json& result);

}  // namespace multum::bench
