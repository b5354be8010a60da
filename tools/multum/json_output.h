// SPDX-License-Identifier: Apache-2.0
// Prints the result of a command as JSON (--json). The only output on stdout is one document.
#pragma once

#include <CLI/CLI.hpp>

#include <string>

#include <nlohmann/json.hpp>

#include "tools/multum/commands.h"

namespace multum {

using OrderedJson = nlohmann::ordered_json;

/// The heading for the options that most commands share.
inline constexpr char kCommonGroup[] = "Common";

/// Adds --json to a command that has no common options.
CLI::Option* add_json_option(CLI::App& command, bool& json);

/// True if the command prints human-readable text, because neither --quiet nor --json was given.
inline bool prints_text(const CommonOptions& options) { return !options.quiet && !options.json; }

/// Prints the document with indentation and escaped control characters.
void print_json(const OrderedJson& json);

/// Parses a JSON text that this program made.
OrderedJson parsed(const std::string& json_text);

/// Returns a path as a JSON string. Bytes that are not valid UTF-8 are encoded (host/foundation/base/path_text.h).
OrderedJson path_json(const std::string& path);

}  // namespace multum
