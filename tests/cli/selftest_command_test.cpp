// SPDX-License-Identifier: Apache-2.0
// Tests multum selftest as a user runs it: its output, its files and its refusals. tests/hard_cases/selftest_test.cpp
// tests that a broken guard is named.
#include <gtest/gtest.h>

#include <filesystem>

#include <nlohmann/json.hpp>

#include "tests/cli/program.h"

namespace multum::testing {
namespace {

class SelftestCommandTest : public CliTest {};

TEST_F(SelftestCommandTest, NamesTheDeviceAndEveryCase) {
  const ProgramResult result = multum({"selftest", "--filter", "movmf_level_zero", "--report", path("verdicts.json")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* part : {"device  ", "driver", "a-dead-lobe-takes-nothing", "any-normal-gets-a-lobe",
                           "a-lobe-of-no-direction", "ok", "4 cases, 0 broken"})
    EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
  EXPECT_EQ(result.out.find("without"), std::string::npos) << "a column must not show variants that were not run";
  const nlohmann::json json = nlohmann::json::parse(read_bytes(path("verdicts.json")));
  EXPECT_TRUE(json.at("holds").get<bool>());
  EXPECT_EQ(json.at("cases").size(), 4u);
  EXPECT_FALSE(json.at("device").get<std::string>().empty());
  EXPECT_TRUE(json.at("cases")[0].at("worst_without_guard").is_null());
}

TEST_F(SelftestCommandTest, ShowsWhatGuardsAreFor) {
  const ProgramResult result = multum({"selftest", "--filter", "exp2-far-below", "--without-guards"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("without"), std::string::npos);
  EXPECT_NE(result.out.find("NaN"), std::string::npos) << result.out;
}

TEST_F(SelftestCommandTest, RefusesWhatItCannotDo) {
  const std::pair<std::vector<std::string>, const char*> refused[] = {
      {{"selftest", "--filter", "nothing-like-it"}, "nothing-like-it"},
      {{"selftest", "--with", "gl.json"}, "--markdown"},
      {{"selftest", "--markdown", path("page.md"), "--filter", "exp2"}, "--filter"}};
  for (const auto& [arguments, part] : refused) {
    expect_refusal(multum(arguments), kUsage, {part});
  }
  const ProgramResult missing = multum({"selftest", "--markdown", path("page.md"), "--with", path("none.json")});
  expect_refusal(missing, kInput, {"none.json"});
  const ProgramResult device = multum({"selftest", "--device", "no such device"});
  EXPECT_EQ(device.exit_code, 4);
  EXPECT_FALSE(std::filesystem::exists(path("page.md")));
}

}  // namespace
}  // namespace multum::testing
