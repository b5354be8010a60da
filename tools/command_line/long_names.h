// SPDX-License-Identifier: Apache-2.0
// Refuses names of files that are too long for any file system, before a command does anything.
#pragma once

#include <CLI/CLI.hpp>

namespace multum {

/// Has app.parse() look at all values of the command line before it runs a command: one that no file can have for a
/// name throws Error(kUsage), which names the option, and says how long the name is and may be.
void refuse_long_names(CLI::App& app);

}  // namespace multum
