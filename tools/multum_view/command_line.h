// SPDX-License-Identifier: Apache-2.0
// Implements the command line of multum-view, with its subcommands and the older options that they replaced.
#pragma once

namespace multum {

/// Returns the program's exit code. Throws Error if the command fails.
int run_view_command(int argc, char** argv);

}  // namespace multum
