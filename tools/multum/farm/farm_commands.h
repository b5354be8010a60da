// SPDX-License-Identifier: Apache-2.0
// The commands of the farm. Each function adds a command to `app`. The command sets *exit_code when it runs.
#pragma once

#include "tools/multum/commands.h"

namespace multum {

/// openjd: writes a job bundle that runs another command on a render farm.
void add_openjd_command(CLI::App& app, int* exit_code, CheckWords check_words);
/// serve, and the hidden commands that the service starts.
void add_serve_commands(CLI::App& app, int* exit_code);
/// jobs: the client of a service, with a subcommand per verb.
void add_client_commands(CLI::App& app, int* exit_code);

}  // namespace multum
