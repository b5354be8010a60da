// SPDX-License-Identifier: Apache-2.0
// Prepares the command that a command line names. Checks its file names, makes the folders of its outputs, and limits
// the advice in messages to the options of this command.
#pragma once

#include <CLI/CLI.hpp>

namespace multum {

/// Prepares each command in app.parse() before it runs. A name that is too long for a file system throws Error(kUsage)
/// with the option, the length found and the length allowed. Missing folders of outputs are made. Keep a NewFolders
/// (host/foundation/base/files/output_paths.h) during parse(). Messages may advise only the command's own options
/// (host/foundation/base/messages/option_words.h).
void prepare_commands(CLI::App& app);

}  // namespace multum
