// SPDX-License-Identifier: Apache-2.0
// All that the rest of `multum` knows of fields. A build without them (CMake option MULTUM_FIELDS) has
// no_field_commands.cpp instead.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/asset/baked_verify.h"

namespace multum {

/// Adds animation, infer, pack, unpack and player, and the numerical cases of their kernels.
void add_field_commands(CLI::App& app, int* exit_code);

/// What `multum info` prints of a packed field; unset: the file is none. Throws Error(kInput) for a damaged one.
std::optional<std::string> packed_field_info(const std::string& path);
/// What `multum verify` finds in a packed field; unset: the file is none.
std::optional<std::vector<VerifyFinding>> packed_field_findings(const std::string& path);

/// The files that a job of texture inference names. Throws Error(kInput) for a job that cannot be read.
std::vector<std::string> files_of_inference(const std::string& job);

}  // namespace multum
