// SPDX-License-Identifier: Apache-2.0
// Programs run as a user runs them: stdout and stderr apart, on a terminal or not, with signals sent while they run.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/unit/foundation/base/test_folder.h"
#include "tests/unit/foundation/base/text_parts.h"

namespace multum::testing {

struct ProgramResult {
  int exit_code = -1;  // -1 when a signal ended it
  int signal = 0;      // 0 when it exited
  std::string out, err;
};

/// A program while it runs; killed when the test leaves it running.
class Program {
 public:
  explicit Program(const std::vector<std::string>& arguments);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  pid_t pid() const { return pid_; }
  void send(int signal) const;
  /// What it has written to stderr so far.
  std::string err_so_far() const;
  bool running();
  ProgramResult wait();

 private:
  void remember(int status);
  TemporaryFolder folder_;  // of its stdout and stderr: files never fill up and block it, as pipes do
  pid_t pid_ = -1;
  bool ended_ = false;
  ProgramResult result_;
};

ProgramResult run_program(const std::vector<std::string>& arguments);
/// False where the system has no pseudo terminals, as in a root without /dev/pts.
bool has_pseudo_terminals();

/// The same with a terminal of its own for stdin, stdout and stderr; all output is in `out`.
ProgramResult run_on_terminal(const std::vector<std::string>& arguments);

/// True when `program` answers to `argument` with exit code 0.
bool program_works(const std::string& program, const std::string& argument);

/// Debian's Chromium; empty: there is none.
std::string chromium_path();

/// Exit codes (host/foundation/base/error.h).
inline constexpr int kUsage = 2, kInput = 3, kEnvironment = 4, kVerification = 5;

/// It ended with `exit_code`, and stderr says all of `parts`.
inline void expect_refusal(const ProgramResult& result, int exit_code, const std::vector<std::string>& parts) {
  EXPECT_EQ(result.exit_code, exit_code) << result.out << result.err;
  expect_says(result.err, parts);
}

/// Tests of `multum`: a folder, and commands in it. The programs that they build are kept in the build folder, by all
/// tests in one place.
class CliTest : public ::testing::Test {
 protected:
  CliTest();
  static std::vector<std::string> multum_command(std::vector<std::string> arguments);
  /// A command in this process, by the function that main() calls: OpenCL and the child that decodes images are there
  /// already, as in a worker of the service. One with --threads is a program of its own, since a process keeps the
  /// threads that it began with.
  static ProgramResult multum(const std::vector<std::string>& arguments);
  /// Whether this build of multum has it: it may lack a part (tools/command_line/absent_commands.h).
  static bool has_command(const std::string& name);
  /// The program itself.
  static ProgramResult multum_program(const std::vector<std::string>& arguments);
  /// PREFIX_normal.png and PREFIX_albedo.png of the four-quarter map, in the folder.
  void make_map(const std::string& prefix, int size);
  std::string path(const std::string& name) const { return folder_ / name; }

  TemporaryFolder folder_;
};

}  // namespace multum::testing
