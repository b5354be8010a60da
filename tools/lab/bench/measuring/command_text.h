// SPDX-License-Identifier: Apache-2.0
// A command as results quote it.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

/// As a person would type it in the folder of its files: quoted where a shell wants it, absolute paths cut to the
/// file's name.
std::string command_text(const std::vector<std::string>& command);

}  // namespace multum::bench
