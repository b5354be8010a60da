// SPDX-License-Identifier: Apache-2.0
// Answers a command line that is not run: help on stdout; on stderr the error, and where to read on.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace multum {

/// CLI11's message; of an unknown option, its name and the one that it was meant to be.
std::string parse_error_text(const CLI::App& app, const CLI::Error& error);

/// For CLI::App::failure_message(); the app has the program's name.
std::string usage_error(const CLI::App* app, const CLI::Error& error);

/// Prints what the app has to say of what its parse() threw, and returns the program's exit code.
int print_parse_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace multum
