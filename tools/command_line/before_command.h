// SPDX-License-Identifier: Apache-2.0
// Prepares the command that a command line names. Checks its file names, creates its output folders, and limits the
// advice in messages to the options of this command.
#pragma once

#include <CLI/CLI.hpp>

namespace multum {

/// Prepares each command in app.parse() before it runs. A name that is too long for a file system throws Error(kUsage)
/// with the option, the length found and the length allowed. Missing output folders are created. A NewFolders object
/// (host/foundation/base/files/output_paths.h) must exist during parse(). Messages advise only options of this command
/// (host/foundation/base/messages/option_words.h).
void prepare_commands(CLI::App& app);

}  // namespace multum
