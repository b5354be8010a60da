// SPDX-License-Identifier: Apache-2.0
// Formats a command as results quote it.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

/// Formats a command as a person would type it in the folder of its files. The words are quoted for a shell, and
/// absolute paths are shortened to file names.
std::string command_text(const std::vector<std::string>& command);

}  // namespace multum::bench
