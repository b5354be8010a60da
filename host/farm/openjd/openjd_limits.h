// SPDX-License-Identifier: Apache-2.0
// Checks a job bundle against the specification of Open Job Description ("Template Schemas" 2023-09 with
// TASK_CHUNKING). Checks every limit that applies to the elements of multum's bundles. A farm rejects a template that
// exceeds a limit, either at submission or, worse, when a task begins.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace multum {

constexpr std::size_t kOpenJdParametersMax = 50;  // section 1.1, parameterDefinitions

/// Throws Error(kUsage), which shows the text and its place, if the text is not UTF-8 (section 1: templates are UTF-8
/// documents).
void check_openjd_text(const std::string& what, const std::string& text);

/// Checks a template of openjd_template() and the values of openjd_parameter_values(). Checks names, lengths, counts,
/// ranges and characters, and that references exist. Throws Error(kUsage) for the first violation, with the value found
/// and the value expected.
void check_openjd_limits(const nlohmann::ordered_json& job_template, const nlohmann::ordered_json& parameter_values);

}  // namespace multum
