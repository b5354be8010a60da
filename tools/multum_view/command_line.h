// SPDX-License-Identifier: Apache-2.0
// The command line of multum-view: its subcommands, and the options that stood for them before there were any.
#pragma once

namespace multum {

/// Returns the program's exit code. Throws Error, as what it runs does.
int run_view_command(int argc, char** argv);

}  // namespace multum
