// SPDX-License-Identifier: Apache-2.0
// Prepares the command that a command line names: its values are looked at, and messages learn which options it has.
#pragma once

#include <CLI/CLI.hpp>

namespace multum {

/// Has app.parse() look at all values of the command line before it runs a command: one that no file can have for a
/// name throws Error(kUsage), which names the option, and says how long the name is and may be. The command's options
/// become those that messages may advise (host/foundation/base/messages/option_words.h).
void prepare_commands(CLI::App& app);

}  // namespace multum
