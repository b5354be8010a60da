// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/web_files.h"

#include <algorithm>
#include <map>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"

namespace multum {
namespace {

// "blob:" allows pictures that the page has fetched with its token, which <img> could not send.
constexpr char kSecurityPolicy[] =
    "default-src 'self'; img-src 'self' blob:; object-src 'none'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

std::string content_type(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  MULTUM_CHECK(name.ends_with(".svg"));
  return "image/svg+xml";
}

const std::map<std::string, HttpResponse>& responses() {
  static const std::map<std::string, HttpResponse> all = [] {
    std::map<std::string, HttpResponse> made;
    for (const auto& [name, bytes] : web_files())
      made["/" + name] = {200,
                          content_type(name),
                          std::string(bytes),
                          {{"ETag", '"' + hash_text(bytes).substr(0, 32) + '"'},
                           {"Cache-Control", "no-cache"},
                           {"Content-Security-Policy", kSecurityPolicy},
                           {"Referrer-Policy", "no-referrer"}}};
    made["/"] = made.at("/index.html");
    return made;
  }();
  return all;
}

}  // namespace

const std::map<std::string, std::string_view>& web_files() {
  static const std::map<std::string, std::string_view> all = [] {
    std::map<std::string, std::string_view> files = embedded_web_files();
    files.insert(shared_web_files().begin(), shared_web_files().end());
    return files;
  }();
  return all;
}

HttpResponse web_file_response(const HttpRequest& request) {
  HttpResponse response = responses().at(request.path);
  const auto known = request.headers.find("if-none-match");
  if (known == request.headers.end() || known->second != response.headers.front().second) return response;
  response.status = 304;
  response.body.clear();
  return response;
}

}  // namespace multum
