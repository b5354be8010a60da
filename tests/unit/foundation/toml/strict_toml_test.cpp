// SPDX-License-Identifier: Apache-2.0
// Tests values in TOML files from unknown sources: NUL characters, numbers that are not integers, paths that are not
// valid UTF-8, and names of files that do not exist.
#include "host/foundation/toml/strict_toml.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

class StrictTomlTest : public ::testing::Test {
 protected:
  // Calls use(table) with the only table of the file.
  template <typename Use>
  void with(const std::string& text, const Use& use) {
    write_bytes(path_, text);
    const toml::table root = parse_toml(path_, "a test", {});
    use(StrictTable(path_, root, "", {}, "a test"));
  }
  void expect_refused(const std::string& text, const std::vector<std::string>& parts) {
    expect_error(ErrorCode::kInput, parts, [&] {
      with(text, [](const StrictTable& table) {
        table.whole("size", 0, 65536, 1);
        table.text("name", "");
        if (table.has("list")) table.integers("list");
      });
    });
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "a.toml";
};

TEST_F(StrictTomlTest, NulIsRefusedWhereverItIs) {
  for (const char* text : {"\nname = \"a\\u0000b\"", "\nother = [\"a\", [\"\\U00000000\"]]", "\n\"a\\u0000\" = 1",
                           "\n[\"t\\u0000\"]", "\n[t]\nx = {y = \"\\u0000\"}"})
    expect_refused(text, {path_, "NUL"});
  expect_refused("\nname = \"\\u0000\"", {path_ + ":2"});
  with("name = 'a\\u0000b'", [](const StrictTable& table) { EXPECT_EQ(table.text("name"), "a\\u0000b"); });
}

TEST_F(StrictTomlTest, OnlyIntegersThatFitAreIntegers) {
  for (const char* value :
       {"320.5", "320.0", "4294967616", "-1", "65537", "9223372036854775807", "nan", "inf", "1e2", "\"3\"", "true"})
    expect_refused(std::string("size = ") + value, {path_, "size", "an integer from 0 to 65536"});
  for (const char* value : {"[1, 2.5]", "[4294967297]", "[-1]"})
    expect_refused(std::string("list = ") + value, {path_, "list", "an integer of at least 0"});
  expect_refused("size = 9223372036854775808", {path_, "TOML"});
}

TEST_F(StrictTomlTest, PathsMayHoldAnyByte) {
  with("file = \"caf\\uefe9.png\"\nplain = \"caf\\u00e9.png\"", [](const StrictTable& table) {
    EXPECT_EQ(table.path("file"), "caf\xe9.png");
    EXPECT_EQ(table.text("file"), "caf\uefe9.png");
    EXPECT_EQ(table.path("plain"), "caf\u00e9.png");
    EXPECT_EQ(table.path("none", ""), "");
  });
}

TEST_F(StrictTomlTest, WhatIsNoFileIsRefusedAtOnce) {
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  expect_error(ErrorCode::kInput, {path_, "FIFO"}, [&] { parse_toml(path_, "a test", {}); });
  expect_error(ErrorCode::kInput, {"/dev/zero", "a device"}, [] { parse_toml("/dev/zero", "a test", {}); });
}

}  // namespace
}  // namespace multum::testing
