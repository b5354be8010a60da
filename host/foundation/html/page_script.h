// SPDX-License-Identifier: Apache-2.0
// Combines JavaScript modules into one classic script, for pages that are a single file.
#pragma once

#include <string>
#include <string_view>

namespace multum {

/// Returns the text of a module without its imports, and with its exports as plain declarations. In the combined
/// script, a module must come after the modules that it imports, and no two modules may declare the same name at top
/// level.
std::string plain_script(std::string_view module_text);

/// Stops the program if the text of a script would end its <script> element.
void check_script(const std::string& script);

}  // namespace multum
