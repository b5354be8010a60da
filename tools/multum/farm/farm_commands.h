// SPDX-License-Identifier: Apache-2.0
// The commands of the farm. Each adds its options to `app` and, when it is chosen, sets *exit_code.
#pragma once

#include "tools/multum/commands.h"

namespace multum {

/// openjd: writes another command as a job bundle for render farms.
void add_openjd_command(CLI::App& app, int* exit_code, CheckWords check_words);
/// serve, and the hidden commands that it starts.
void add_serve_commands(CLI::App& app, int* exit_code);
/// jobs: the client of a service, with a subcommand per verb.
void add_client_commands(CLI::App& app, int* exit_code);

}  // namespace multum
