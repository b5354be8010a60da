// SPDX-License-Identifier: Apache-2.0
// Tests multum doctor on a working machine, and on machines where a component is missing.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/cli/program.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

// Holds the findings of each area. The text of a finding contains its state, what was found, and what to do.
using Findings = std::map<std::string, std::vector<std::string>>;

Findings findings_of(const std::string& out) {
  Findings findings;
  const nlohmann::json json = nlohmann::json::parse(out);
  for (const nlohmann::json& row : json.at("findings"))
    findings[row.at("area")].push_back(row.at("state").get<std::string>() + " " + row.at("found").get<std::string>() +
                                       " -> " + row.at("advice").get<std::string>());
  return findings;
}

class DoctorCommandTest : public CliTest {
 protected:
  // Runs `multum doctor --json` in its own process with these environment variables.
  ProgramResult doctor(const std::vector<std::string>& variables,
                       const std::vector<std::string>& arguments = {}) const {
    std::vector<std::string> command = {"env", "-u", "MULTUM_SERVER"};
    command.insert(command.end(), variables.begin(), variables.end());
    const std::vector<std::string> program = multum_command({"doctor", "--json"});
    command.insert(command.end(), program.begin(), program.end());
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run_program(command);
  }

  // Expects that this area has one failure, whose text contains these parts.
  static void expect_failure(const ProgramResult& result, const std::string& area,
                             const std::vector<std::string>& parts) {
    expect_refusal(result, kEnvironment, {"this machine fails"});
    const Findings findings = findings_of(result.out);
    for (const std::string& finding : findings.at(area))
      if (finding.starts_with("failure ")) return expect_says(finding, parts);
    ADD_FAILURE() << "no failure of " << area << ": " << result.out;
  }
};

TEST_F(DoctorCommandTest, SaysThatThisMachineWorks) {
  const ProgramResult result = doctor({"TMPDIR=" + path("")});
  ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
  Findings findings = findings_of(result.out);
  for (const char* const area : {"machine", "OpenCL", "decoder", "disk", "bake"})
    EXPECT_TRUE(findings[area].at(0).starts_with("ok ")) << findings[area].at(0);
  EXPECT_EQ(findings["GL"].size(), 2u) << "one finding per context";
  EXPECT_TRUE(findings["GL"][0].starts_with("ok ") || findings["GL"][1].starts_with("ok ")) << result.out;
  EXPECT_TRUE(fs::is_empty(path(""))) << "its files are removed";
  const ProgramResult text = run_program(multum_command({"doctor"}));
  EXPECT_NE(text.out.find("0 failures, "), std::string::npos) << text.out;
}

TEST_F(DoctorCommandTest, SaysWhatIsMissingAndWhatToDo) {
  expect_failure(doctor({}, {"--device", "no such device"}), "OpenCL", {"no such device", "multum devices"});
  expect_failure(doctor({"OCL_ICD_VENDORS=/nowhere"}), "OpenCL", {"no device", "pocl-opencl-icd"});
  expect_failure(doctor({"TMPDIR=/proc/nowhere"}), "disk", {"/proc/nowhere", "TMPDIR"});
}

TEST_F(DoctorCommandTest, AServiceThatIsNamedMustAnswer) {
  if (!has_command("serve")) GTEST_SKIP() << "this build has no farm";
  expect_failure(doctor({"MULTUM_SERVER=http://127.0.0.1:1"}), "service", {"127.0.0.1:1", "multum serve"});
  expect_failure(doctor({}, {"--server", "unix:" + path("none")}), "service", {path("none"), "--server"});
}

TEST_F(DoctorCommandTest, WarnsAboutCachesThatCannotBeKept) {
  const ProgramResult off = doctor({"MULTUM_CACHE_DIR="});
  EXPECT_EQ(off.exit_code, 0) << off.err;
  EXPECT_TRUE(findings_of(off.out)["cache"][0].starts_with("warning ")) << off.out;
  const ProgramResult read_only = doctor({"POCL_CACHE_DIR=/proc/nowhere"});
  EXPECT_EQ(read_only.exit_code, 0) << read_only.err;
  const std::string finding = findings_of(read_only.out)["cache"][1];
  EXPECT_TRUE(finding.starts_with("warning ")) << finding;
  EXPECT_NE(finding.find("POCL_CACHE_DIR"), std::string::npos) << finding;
}

}  // namespace
}  // namespace multum::testing
