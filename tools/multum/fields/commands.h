// SPDX-License-Identifier: Apache-2.0
// Declares the subcommands of `multum` for fields.
#pragma once

#include "tools/multum/commands.h"

namespace multum {

void add_animation_command(CLI::App& app, int* exit_code);
void add_infer_command(CLI::App& app, int* exit_code);
/// Adds pack and unpack.
void add_pack_commands(CLI::App& app, int* exit_code);
void add_player_command(CLI::App& app, int* exit_code);

}  // namespace multum
