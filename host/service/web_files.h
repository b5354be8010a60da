// SPDX-License-Identifier: Apache-2.0
// Files that the daemon serves by itself: the page, and the description of its interface.
#pragma once

#include <string>
#include <string_view>

namespace multum {

struct WebFile {
  const char* path;  // "/"
  const char* content_type;
  std::string_view content;
};

/// Null: there is none of this path.
const WebFile* find_web_file(const std::string& path);

}  // namespace multum
