// SPDX-License-Identifier: Apache-2.0
// Looks into pages of host/foundation/html: at the data that a page holds, and at what a browser makes of them.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace multum::testing {

/// The block of JSON in the page.
nlohmann::json page_data(const std::string& page);

/// The elements that headless Chromium has when the page's script has run, as HTML, without scripts and styles; nullopt
/// where there is no Chromium.
std::optional<std::string> rendered_page(const std::string& page);

}  // namespace multum::testing
