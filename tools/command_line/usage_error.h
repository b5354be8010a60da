// SPDX-License-Identifier: Apache-2.0
// Prints help to stdout. Prints errors of a command line to stderr, together with the command that prints the help.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace multum {

/// Returns the message of CLI11. For an unknown option, returns its name and the most similar option.
std::string parse_error_text(const CLI::App& app, const CLI::Error& error);

/// Makes the message for CLI::App::failure_message(). The app must have the program's name.
std::string usage_error(const CLI::App* app, const CLI::Error& error);

/// Prints the help, version or error that parse() threw, and returns the program's exit code.
int print_parse_error(const CLI::App& app, const CLI::ParseError& error);

/// Returns the table of exit codes, with a heading, that ends every help text.
std::string exit_codes_text();

}  // namespace multum
