// SPDX-License-Identifier: Apache-2.0
// The subcommands of `multum`. Each adds its options to `app` and, when it is chosen, sets *exit_code.
#pragma once

#include <CLI/CLI.hpp>

namespace multum {

/// Options that every command shares.
struct CommonOptions {
  int threads = 0;  // 0: all cores
  bool verbose = false;
  bool quiet = false;
};

/// Applies verbosity and thread count to everything below; to be called before the first OpenCL or image call.
/// Returns the thread count.
int apply(const CommonOptions& options);
void add_common_options(CLI::App& command, CommonOptions& options);

void add_animation_command(CLI::App& app, int* exit_code);
void add_bake_command(CLI::App& app, int* exit_code);
void add_infer_command(CLI::App& app, int* exit_code);
void add_devices_command(CLI::App& app, int* exit_code);
void add_info_command(CLI::App& app, int* exit_code);
void add_verify_command(CLI::App& app, int* exit_code);
void add_testmap_command(CLI::App& app, int* exit_code);

}  // namespace multum
