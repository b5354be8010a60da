// SPDX-License-Identifier: Apache-2.0
// Tests that docs/reference/openapi.json lists every route of the service and every parameter of every type of job. The
// tests in tests/service compare answers with this file.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "host/farm/service/http/http_api.h"
#include "host/farm/service/http/openapi.h"
#include "host/farm/service/workers/job_types.h"

namespace multum {
namespace {

using Json = nlohmann::json;

std::string parameters_name(const JobType& type) {
  std::string name = type.name + "Parameters";
  name[0] = static_cast<char>(name[0] - 'a' + 'A');
  return name;
}

TEST(Openapi, HasEveryRouteAndNoOther) {
  std::set<std::string> described;
  const Json document = Json::parse(openapi_json);
  for (const auto& [path, operations] : document.at("paths").items())
    for (const auto& [method, operation] : operations.items()) {
      std::string upper = method;
      for (char& c : upper) c = static_cast<char>(c - 'a' + 'A');
      described.insert(upper + " " + std::regex_replace(path, std::regex("\\{[a-z_]+\\}"), "{}"));
    }
  const std::vector<std::string> routes = HttpApi::routes();
  EXPECT_EQ(described, std::set<std::string>(routes.begin(), routes.end()));
}

TEST(Openapi, HasTheParametersOfEveryType) {
  const Json schemas = Json::parse(openapi_json).at("components").at("schemas");
  std::vector<std::string> names;
  for (const JobType& type : job_types()) {
    names.push_back(type.name);
    const std::string name = parameters_name(type);
    ASSERT_TRUE(schemas.contains(name)) << name;
    EXPECT_EQ(schemas.at(name), parameters_schema(type)) << "expected " << name << ": " << parameters_schema(type);
  }
  EXPECT_EQ(schemas.at("Submission").at("properties").at("type").at("enum"), Json(names));
  EXPECT_EQ(schemas.at("Submission").at("allOf").size(), names.size()) << "one schema of parameters per type";
}

// Tests labels, queue names and texts. Terminals obey C1 characters, U+0080 to U+009F, in the same way as ESC.
TEST(Openapi, TextsHoldNoControlCharacters) {
  for (unsigned code = 0; code < 0x120; ++code) {
    std::string text = "a";
    if (code >= 0x80) text += static_cast<char>(0xc0 | code >> 6);
    text += static_cast<char>(code < 0x80 ? code : 0x80 | (code & 63));
    EXPECT_EQ(is_plain_text(text), code >= 0x20 && (code < 0x7f || code >= 0xa0)) << code;
  }
  const Json schemas = Json::parse(openapi_json).at("components").at("schemas");
  const Json pattern = parameters_schema(find_job_type("bake")).at("properties").at("device").at("pattern");
  for (const char* key : {"label", "queue", "device"})
    EXPECT_EQ(schemas.at("Submission").at("properties").at(key).at("pattern"), pattern) << key;
}

TEST(Openapi, EveryReferenceLeadsSomewhere) {
  const Json document = Json::parse(openapi_json);
  int references = 0;
  const auto follow = [&](const auto& self, const Json& node) -> void {
    if (!node.is_structured()) return;
    if (node.is_object() && node.contains("$ref")) {
      const std::string target = node.at("$ref").get<std::string>();
      EXPECT_TRUE(document.contains(Json::json_pointer(target.substr(1)))) << target;
      ++references;
    }
    for (const Json& child : node) self(self, child);
  };
  follow(follow, document);
  EXPECT_GT(references, 50);
}

}  // namespace
}  // namespace multum
