// SPDX-License-Identifier: Apache-2.0
// Declares all functions of fields that the rest of `multum` uses. A build without fields (CMake option MULTUM_FIELDS)
// uses no_field_commands.cpp instead.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/asset/baked_verify.h"
#include "tools/multum/json_output.h"

namespace multum {

/// Adds animation, infer, pack, unpack and player. Also adds the numerical test cases of their kernels.
void add_field_commands(CLI::App& app, int* exit_code);

/// Returns the text of `multum info` about a packed field, or nullopt for any other file. Throws Error(kInput) for a
/// damaged packed field.
std::optional<std::string> packed_field_info(const std::string& path);
/// Returns the document of `multum info --json` about a packed field, or nullopt for any other file.
std::optional<OrderedJson> packed_field_json(const std::string& path);
/// Returns the findings of `multum verify` about a packed field, or nullopt for any other file.
std::optional<std::vector<VerifyFinding>> packed_field_findings(const std::string& path);

/// Returns the files that a job of texture inference names. Throws Error(kInput) for a job that cannot be read.
std::vector<std::string> files_of_inference(const std::string& job);

}  // namespace multum
