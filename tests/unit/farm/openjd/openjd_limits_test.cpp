// SPDX-License-Identifier: Apache-2.0
// Tests each limit of Open Job Description's "Template Schemas" 2023-09 that a bundle could exceed. The largest allowed
// value is accepted, and one more is refused. tests/cli/farms validates whole bundles against the schema.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "host/farm/openjd/openjd_bundle.h"
#include "host/farm/openjd/openjd_limits.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

FarmCommand command_of(std::size_t path_count, int shards = 1) {
  FarmCommand command;
  command.name = "multum bake";
  command.words = {"bake"};
  for (std::size_t i = 0; i < path_count; ++i) {
    command.words.push_back(fmt::format("/maps/m{}.png", i));
    command.paths.push_back({i + 1, command.words.back()});
  }
  command.shards = shards;
  command.threads = 2;
  return command;
}

// Returns why a bundle is refused, or "".
std::string refusal(const FarmJson& job, const FarmJson& values) {
  try {
    check_openjd_limits(job, values);
    return "";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    return error.what();
  }
}
std::string refusal(const FarmCommand& command) {
  return refusal(openjd_template(command), openjd_parameter_values(command));
}

TEST(OpenJdLimits, BundlesOfAllKindsAreWithin) {
  EXPECT_EQ(refusal(command_of(2)), "");
  EXPECT_EQ(refusal(command_of(2, 8)), "");
  for (bool FarmCommand::*kind : {&FarmCommand::is_one_map, &FarmCommand::is_merged}) {
    FarmCommand command = command_of(2, 8);
    command.*kind = true;
    EXPECT_EQ(refusal(command), "");
  }
}

TEST(OpenJdLimits, ParametersAreFiftyWithTheProgram) {
  EXPECT_EQ(refusal(command_of(49)), "");
  EXPECT_NE(refusal(command_of(50)).find("has 51 elements, expected 1 to 50"), std::string::npos);
}

struct Edit {
  const char* name;
  std::function<void(FarmJson& job, std::size_t more)> change;  // `more` is 0 for a value within the limit and 1 for a
                                                                // value beyond it
  const char* expected;
};

std::string characters(std::size_t count, const std::string& one = "x") {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += one;
  return text;
}

TEST(OpenJdLimits, WhatIsWithinIsTakenAndOneMoreIsRefused) {
  const Edit edits[] = {
      {"job name", [](FarmJson& job, std::size_t more) { job["name"] = characters(128 + more); }, "at most 128"},
      {"job name, of long characters",
       [](FarmJson& job, std::size_t more) { job["name"] = characters(128 + more, "\xf0\x9f\xaa\xa8"); },
       "has 129 characters"},
      {"description", [](FarmJson& job, std::size_t more) { job["description"] = characters(2048 + more); }, "2048"},
      {"description of a parameter",
       [](FarmJson& job, std::size_t more) {
         job["parameterDefinitions"].back()["description"] = characters(2047, "\n") + (more == 0 ? "\t" : "\x7f");
       },
       "U+007F"},
      {"default",
       [](FarmJson& job, std::size_t more) { job["parameterDefinitions"].back()["default"] = characters(1024 + more); },
       "at most 1024"},
      {"step name", [](FarmJson& job, std::size_t more) { job["steps"][0]["name"] = characters(64 + more); }, "64"},
      {"task parameter's name",
       [](FarmJson& job, std::size_t more) {
         job["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["name"] = characters(64 + more);
         job["steps"][0]["script"]["actions"]["onRun"]["args"] = {"x"};
       },
       "at most 64"},
      {"task parameters",
       [](FarmJson& job, std::size_t more) {
         FarmJson& all = job["steps"][0]["parameterSpace"]["taskParameterDefinitions"];
         for (std::size_t i = 0; i < 15 + more; ++i)
           all.push_back({{"name", fmt::format("P{}", i)}, {"type", "INT"}, {"range", "1-2"}});
       },
       "has 17 elements, expected 1 to 16"},
      {"list of a range",
       [](FarmJson& job, std::size_t more) {
         FarmJson& range = job["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["range"];
         range = FarmJson::array();
         for (std::size_t i = 0; i < 1024 + more; ++i) range.push_back(i);
       },
       "has 1025 elements"},
      {"range",
       [](FarmJson& job, std::size_t more) {
         job["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["range"] = more == 0 ? "3-3" : "3-2";
       },
       "is 3-2"},
      {"requirements",
       [](FarmJson& job, std::size_t more) {
         FarmJson& all = job["steps"][0]["hostRequirements"]["amounts"];
         for (std::size_t i = 0; i < 49 + more; ++i)
           all.push_back({{"name", fmt::format("amount.a{}", i)}, {"min", 0}});
       },
       "has 51 elements"},
      {"requirement's name",
       [](FarmJson& job, std::size_t more) {
         job["steps"][0]["hostRequirements"]["amounts"][0]["name"] = "amount." + characters(93 + more);
       },
       "at most 100"},
      {"processors",
       [](FarmJson& job, std::size_t more) {
         job["steps"][0]["hostRequirements"]["amounts"][0]["min"] = more == 0 ? 1 : 0;
       },
       "a number from 1"},
      {"notice",
       [](FarmJson& job, std::size_t more) {
         job["steps"][0]["script"]["actions"]["onRun"]["cancelation"]["notifyPeriodInSeconds"] = 600 + more;
       },
       "1 to 600"},
      {"chunks",
       [](FarmJson& job, std::size_t more) {
         job["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["chunks"]["defaultTaskCount"] = 1 - more;
       },
       "1 or more"},
      {"extension's name",
       [](FarmJson& job, std::size_t more) { job["extensions"].push_back(characters(128 + more, "X")); },
       "at most 128"},
      {"extensions",
       [](FarmJson& job, std::size_t more) {
         if (more > 0) job["extensions"] = FarmJson::array();
       },
       "has 0 elements"},
      {"what chunks need",
       [](FarmJson& job, std::size_t more) {
         if (more > 0) job.erase("extensions");
       },
       "TASK_CHUNKING"},
      {"two steps",
       [](FarmJson& job, std::size_t more) {
         job["steps"].push_back(job["steps"][0]);
         if (more == 0) job["steps"][1]["name"] = "Other";
       },
       "occurs twice"},
      {"dependency",
       [](FarmJson& job, std::size_t more) {
         job["steps"].push_back(job["steps"][0]);
         job["steps"][1]["name"] = "Other";
         job["steps"][1]["dependencies"] = {{{"dependsOn", more == 0 ? "Run" : "Other"}}};
       },
       "a step before it"},
      {"reference",
       [](FarmJson& job, std::size_t more) {
         job["steps"][0]["script"]["actions"]["onRun"]["args"].push_back(more == 0 ? "{{ Param.Input2 }}"
                                                                                   : "{{Param.In}}");
       },
       "which is not defined"},
      {"braces",
       [](FarmJson& job, std::size_t more) {
         job["steps"][0]["script"]["actions"]["onRun"]["args"].push_back(more == 0 ? "a}{b" : "a}}b");
       },
       "{{ or }}"},
      {"word",
       [](FarmJson& job, std::size_t more) {
         job["steps"][0]["script"]["actions"]["onRun"]["args"].push_back(more == 0 ? "\xc2\xa0" : "\xc2\x9f");
       },
       "U+009F"},
  };
  const FarmCommand command = command_of(2, 8);
  const FarmJson job = openjd_template(command), values = openjd_parameter_values(command);
  for (const Edit& edit : edits) {
    FarmJson within = job, beyond = job;
    edit.change(within, 0);
    edit.change(beyond, 1);
    EXPECT_EQ(refusal(within, values), "") << edit.name;
    EXPECT_NE(refusal(beyond, values).find(edit.expected), std::string::npos) << edit.name << refusal(beyond, values);
  }
}

TEST(OpenJdLimits, OfPathsTheirLengthAndCharacters) {
  const auto refusal_of = [](const std::string& path) {
    FarmCommand command = command_of(1);
    command.words[1] = command.paths[0].path = path;
    return refusal(command);
  };
  EXPECT_EQ(refusal_of("/" + characters(1023, "\xc3\xa9")), "") << "characters, not bytes";
  EXPECT_NE(refusal_of("/" + characters(1024)).find("at most 1024"), std::string::npos);
  for (const char* control : {"\x01", "\n", "\t", "\x1f", "\x7f", "\xc2\x80", "\xc2\x85", "\xc2\x9f"})
    EXPECT_NE(refusal_of(std::string("/maps/a") + control + ".png").find("control character"), std::string::npos);
  for (const char* fine : {" ", "~", "\xc2\xa0", "\xc3\xa9", "\xe2\x80\xa8", "\xf0\x9f\xaa\xa8"})
    EXPECT_EQ(refusal_of(std::string("/maps/a") + fine + ".png"), "") << fine;
  for (const char* broken : {"\xff", "\x80", "\xc3", "\xc0\xaf", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80"})
    EXPECT_NE(refusal_of(std::string("/maps/a") + broken + ".png").find("is not UTF-8"), std::string::npos);
}

}  // namespace
}  // namespace multum
