// SPDX-License-Identifier: Apache-2.0
// The page that the daemon serves: files of host/farm/service/web and some of runtime_gl/web, embedded at build time.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "host/farm/service/http/http_server.h"

namespace multum {

/// Of the service alone, by name, e.g. "app.js", and what other pages have too. Made by tools/embed_files.py.
const std::map<std::string, std::string_view>& embedded_web_files();
const std::map<std::string, std::string_view>& shared_web_files();
/// Both together.
const std::map<std::string, std::string_view>& web_files();

/// Answers "/" and "/NAME" for each of them, 304 to who has it already. The page may load nothing from elsewhere and
/// run no script but its own, whatever text of strangers it shows.
HttpResponse web_file_response(const HttpRequest& request);

}  // namespace multum
