// SPDX-License-Identifier: Apache-2.0
// Holds a job bundle to every limit that the specification of Open Job Description sets for what bundles of multum
// consist of: "Template Schemas" 2023-09 with TASK_CHUNKING. A farm refuses a template that breaks one of them, when it
// is sent or, worse, when a task of it begins.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace multum {

constexpr std::size_t kOpenJdParametersMax = 50;  // 1.1, parameterDefinitions

/// Throws Error(kUsage), with what holds the text and where, unless it is UTF-8 (1: templates are UTF-8 documents).
void check_openjd_text(const std::string& what, const std::string& text);

/// A template, as openjd_template() makes it, and its parameters' values, as openjd_parameter_values() does: names,
/// lengths, counts, ranges and characters, and that what is referred to is there. Throws Error(kUsage) for the first
/// thing that is not allowed, with what was found and what is expected.
void check_openjd_limits(const nlohmann::ordered_json& job_template, const nlohmann::ordered_json& parameter_values);

}  // namespace multum
