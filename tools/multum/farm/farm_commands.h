// SPDX-License-Identifier: Apache-2.0
// Declares the commands of the farm. Each function adds a command to `app`. When the command runs, it sets *exit_code.
#pragma once

#include "tools/multum/commands.h"

namespace multum {

/// Adds openjd, which writes a job bundle that runs another command on a render farm.
void add_openjd_command(CLI::App& app, int* exit_code, CheckWords check_words);
/// Adds serve, and the hidden commands that the service starts.
void add_serve_commands(CLI::App& app, int* exit_code);
/// Adds jobs, the client of a service, with one subcommand per verb.
void add_client_commands(CLI::App& app, int* exit_code);

}  // namespace multum
