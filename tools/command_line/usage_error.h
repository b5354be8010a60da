// SPDX-License-Identifier: Apache-2.0
// Prints help to stdout, or the error of a command line to stderr with a hint where to read on.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace multum {

/// The message of CLI11. For an unknown option: its name and the option with the nearest name.
std::string parse_error_text(const CLI::App& app, const CLI::Error& error);

/// Message for CLI::App::failure_message(); the app must have the program's name.
std::string usage_error(const CLI::App* app, const CLI::Error& error);

/// Prints the help, version or error that parse() threw, and returns the program's exit code.
int print_parse_error(const CLI::App& app, const CLI::ParseError& error);

/// The table of exit codes that ends every help text, with a heading.
std::string exit_codes_text();

}  // namespace multum
