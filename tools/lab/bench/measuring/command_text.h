// SPDX-License-Identifier: Apache-2.0
// Writes a command in the form in which results quote it.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

/// Writes a command as a person would type it in the folder of its files. It is quoted for a shell, and absolute paths
/// are shortened to file names.
std::string command_text(const std::vector<std::string>& command);

}  // namespace multum::bench
