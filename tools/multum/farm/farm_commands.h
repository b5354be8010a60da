// SPDX-License-Identifier: Apache-2.0
// The commands of the farm. Each adds its options to `app` and, when it is chosen, sets *exit_code.
#pragma once

#include "tools/multum/commands.h"

namespace multum {

/// Another command's words as a bundle for farms.
void add_openjd_command(CLI::App& app, int* exit_code, CheckWords check_words);
/// serve, the worker that it starts, and rescue.
void add_serve_commands(CLI::App& app, int* exit_code);
/// submit, list, show, tail, wait, cancel, retry, purge: a service's clients.
void add_client_commands(CLI::App& app, int* exit_code);

}  // namespace multum
