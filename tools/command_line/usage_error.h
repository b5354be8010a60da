// SPDX-License-Identifier: Apache-2.0
// What a wrong command line gets on stderr: what is wrong with it, and where to read on.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace multum {

/// For CLI::App::failure_message(); the app has the program's name.
std::string usage_error(const CLI::App* app, const CLI::Error& error);

}  // namespace multum
