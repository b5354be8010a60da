// SPDX-License-Identifier: Apache-2.0
// Tests JSON from unknown sources: NUL characters in texts, and numbers outside the expected range of integers. Also
// tests JSON for other programs, with texts that are not valid UTF-8.
#include "host/foundation/base/files/json_file.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/foundation/base/path_text.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

using Json = nlohmann::json;

TEST(JsonFileTest, NulInTextsIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "a.json";
  for (const char* text : {R"({"name": "a\u0000b"})", R"({"a\u0000": 1})", R"(["\\\u0000"])", R"(["\n\u0000")"}) {
    write_bytes(path, text);
    expect_error(ErrorCode::kInput, {path, "NUL"}, [&] { json_of_file(path); });
  }
  for (const char* text :
       {R"(["\\u0000"])", R"(["\u0001\u0010"])", R"(["u0000"])", R"(["\\\\u0000"])", R"(["\u00e9"])"}) {
    write_bytes(path, text);
    EXPECT_EQ(json_of_file(path), text);
    EXPECT_FALSE(Json::parse(text, nullptr, false).is_discarded()) << text;
  }
  EXPECT_TRUE(holds_nul(std::string_view("[\"\0\"]", 5)));
}

TEST(JsonFileTest, IntegersThatDoNotFitAreRefused) {
  const Json values = Json::parse(
      R"({"good": 7, "fraction": 320.5, "whole float": 320.0, "wrapped": 4294967616, "huge": 18446744073709551615,)"
      R"("huge float": 1e30, "negative": -1, "text": "7", "null": null, "list": [1, 2, 2.5]})");
  EXPECT_EQ(json_integer(values, "good", 1, 7), 7);
  EXPECT_EQ(json_int(values, "negative"), -1);
  for (const char* key : {"text", "null", "list"}) EXPECT_THROW(json_int(values, key), Json::type_error) << key;
  for (const char* key : {"fraction", "whole float", "wrapped", "huge", "huge float"}) {
    expect_error(ErrorCode::kInput, {key, "expected an integer"}, [&] { json_int(values, key); });
    expect_error(ErrorCode::kInput, {key, "from 0 to 65536"}, [&] { json_integer(values, key, 0, 65536); });
  }
  expect_error(ErrorCode::kInput, {"320.5"}, [&] { json_int(values, "fraction"); });
  expect_error(ErrorCode::kInput, {"huge", "18446744073709551615"},
               [&] { json_integer(values, "huge", 0, INT64_MAX); });
  expect_error(ErrorCode::kInput, {"list[2] is 2.5"}, [&] { json_ints(values, "list"); });
  EXPECT_THROW(json_ints(values, "good"), Json::type_error);
  EXPECT_THROW(json_int(values, "none"), Json::out_of_range);
}

TEST(JsonFileTest, TextsThatAreNotUtf8AreReversible) {
  const std::string name = "n\xff\xe9.png";
  const Json made = {{"input", name}, {name, {1, name}}, {"good", "caf\u00e9"}};
  const Json read = Json::parse(json_text(made, 2));
  EXPECT_EQ(path_of_text(read["input"].get<std::string>()), name);
  EXPECT_EQ(path_of_text(read[text_of_path(name)][1].get<std::string>()), name);
  EXPECT_EQ(read["good"], "caf\u00e9");
  EXPECT_EQ(json_text(read, 2), json_text(made, 2)) << "escaped text is not escaped again";
  const nlohmann::ordered_json ordered = {{"z", name}, {"a", 1}};
  EXPECT_EQ(json_text(ordered), "{\"z\":\"n\uefff\uefe9.png\",\"a\":1}");
  EXPECT_EQ(json_text(ordered, -1, true), R"({"z":"n\uefff\uefe9.png","a":1})");
}

}  // namespace
}  // namespace multum::testing
