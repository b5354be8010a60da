// SPDX-License-Identifier: Apache-2.0
// Tests names and texts with control characters. The program escapes them on a terminal, and leaves them unchanged in a
// pipe.
#include <regex>
#include <sstream>

#include "tests/cli/program.h"

namespace multum::testing {
namespace {

// The name contains ESC, and a C1 control character twice: once as UTF-8 and once as a single byte. 8-bit terminals
// interpret this C1 character as ESC [.
const std::string kName =
    "q\x1b[31m\xc2\x9b"
    "2J\x9b"
    "5n\x7f";
const std::string kShown = "q\\x1b[31m\\xc2\\x9b2J\\x9b5n\\x7f";

class TerminalTest : public CliTest {
 protected:
  void SetUp() override {
    if (!has_pseudo_terminals()) GTEST_SKIP() << "there are no pseudo terminals";
  }
  // A terminal gets the text around a control character but not the control character. A pipe gets the unchanged name.
  void expect_shown(const std::vector<std::string>& arguments, int exit_code) const {
    const ProgramResult shown = run_on_terminal(multum_command(arguments));
    EXPECT_EQ(shown.exit_code, exit_code) << shown.out;
    EXPECT_EQ(shown.out.find_first_of("\x1b\x9b\x7f"), std::string::npos) << shown.out;
    EXPECT_TRUE(contains(shown.out, kShown)) << shown.out;
    const ProgramResult piped = multum_program(arguments);
    EXPECT_EQ(piped.exit_code, exit_code);
    EXPECT_TRUE(contains(piped.out + piped.err, kName)) << piped.out << piped.err;
    EXPECT_FALSE(contains(piped.out + piped.err, kShown));
  }
};

TEST_F(TerminalTest, NamesInErrors) {
  expect_shown({"info", path(kName + ".exr")}, kInput);
  expect_shown({"verify", path(kName + ".exr")}, kInput);
  expect_shown({"plan", path(kName + ".toml")}, kInput);
  expect_shown({kName}, kUsage);
  expect_shown({"info", path("a.exr"), "--" + kName}, kUsage);
}

TEST_F(TerminalTest, NamesInResults) {
  make_map("map", 16);
  std::filesystem::rename(path("map_normal.png"), path(kName + ".png"));
  const std::string plain = path("plain.ndf.exr"), baked = path(kName + ".ndf.exr");
  ASSERT_EQ(multum({"bake", path(kName + ".png"), "-o", plain, "--ndf", "moments", "--no-measure"}).exit_code, 0);
  expect_shown({"info", plain}, 0);       // this command prints the name of the source, which the file stores
  std::filesystem::rename(plain, baked);  // renamed by the test: multum writes no such name
  expect_shown({"info", baked}, 0);
}

// The progress bar is erased before a line is written to stdout or stderr, and no line contains the bar.
TEST_F(TerminalTest, BarsDoNotRunIntoLines) {
  make_map("map", 64);
  const ProgramResult shown = run_on_terminal(multum_command(
      {"export", path("map_normal.png"), path("none.png"), "-o", folder_.path(), "--optimum", "--format", "ktx2"}));
  EXPECT_NE(shown.exit_code, 0);
  const std::regex bar(R"(\[[#.]{30}\])");
  EXPECT_TRUE(std::regex_search(shown.out, bar)) << shown.out;
  std::istringstream lines(shown.out);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t last = line.rfind("\x1b[K");
    const std::string left = last == std::string::npos ? line : line.substr(last + 3);
    EXPECT_FALSE(std::regex_search(left, bar)) << line;
  }
}

TEST_F(TerminalTest, TextsOfTomlFiles) {
  write_bytes(path("a.toml"), "[[map]]\n\"q\\u001b[31m\\u009b\" = 1\n");
  const ProgramResult shown = run_on_terminal(multum_command({"bake", "--manifest", path("a.toml")}));
  EXPECT_EQ(shown.exit_code, kInput);
  EXPECT_EQ(shown.out.find_first_of("\x1b\x9b"), std::string::npos) << shown.out;
  EXPECT_TRUE(contains(shown.out, "q\\x1b[31m\\xc2\\x9b")) << shown.out;
}

}  // namespace
}  // namespace multum::testing
