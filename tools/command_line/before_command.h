// SPDX-License-Identifier: Apache-2.0
// Prepares the command that a command line names: checks its file names, makes the folders of its outputs, and tells
// messages which options it has.
#pragma once

#include <CLI/CLI.hpp>

namespace multum {

/// Makes app.parse() do the following before it runs a command. A name that is too long for a file system throws
/// Error(kUsage) with the option, the length found and the length allowed. Missing folders of outputs are made; keep a
/// NewFolders (host/foundation/base/files/output_paths.h) during parse(). Messages may advise the command's own options
/// only (host/foundation/base/messages/option_words.h).
void prepare_commands(CLI::App& app);

}  // namespace multum
