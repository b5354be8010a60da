// SPDX-License-Identifier: Apache-2.0
// Modules of JavaScript as one classic script, for pages that are one file.
#pragma once

#include <string>
#include <string_view>

namespace multum {

/// A module's text without what it imports, and with what it exports as plain declarations. Modules that are joined
/// stand in the order of what they import, and no two have a name in common at top level.
std::string plain_script(std::string_view module_text);

/// Stops the program where a script's text would end the <script> that it stands in.
void check_script(const std::string& script);

}  // namespace multum
