// SPDX-License-Identifier: Apache-2.0
// Reads pages of host/foundation/html: the data that a page holds, and the elements that a browser makes of it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace multum::testing {

/// Returns the block of JSON in the page.
nlohmann::json page_data(const std::string& page);

/// Returns headless Chromium's elements after the page's script has run, as HTML without scripts and styles; nullopt if
/// there is no Chromium.
std::optional<std::string> rendered_page(const std::string& page);

}  // namespace multum::testing
