// SPDX-License-Identifier: Apache-2.0
// Runs programs as a user does: separate stdout and stderr, on a terminal or not, with signals sent while they run.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/unit/foundation/base/test_folder.h"
#include "tests/unit/foundation/base/text_parts.h"

namespace multum::testing {

struct ProgramResult {
  int exit_code = -1;  // is -1 if a signal terminated the program
  int signal = 0;      // is 0 if the program exited by itself
  std::string out, err;
};

/// Holds a running program. The destructor kills the program if it still runs.
class Program {
 public:
  explicit Program(const std::vector<std::string>& arguments);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  pid_t pid() const { return pid_; }
  void send(int signal) const;
  /// Returns what the program has written to stderr so far.
  std::string err_so_far() const;
  bool running();
  ProgramResult wait();

 private:
  void remember(int status);
  TemporaryFolder folder_;  // stdout and stderr go to files, which never fill up and block as pipes do
  pid_t pid_ = -1;
  bool ended_ = false;
  ProgramResult result_;
};

ProgramResult run_program(const std::vector<std::string>& arguments);
/// Returns false if the system has no pseudo terminals, as in a root folder without /dev/pts.
bool has_pseudo_terminals();

/// Runs a program with its own terminal for stdin, stdout and stderr; all output is in `out`.
ProgramResult run_on_terminal(const std::vector<std::string>& arguments);

/// Returns whether `program` run with `argument` exits with code 0.
bool program_works(const std::string& program, const std::string& argument);

/// Returns the path of Debian's Chromium, or "" if it is not installed.
std::string chromium_path();

/// These are the exit codes of host/foundation/base/error.h.
inline constexpr int kUsage = 2, kInput = 3, kEnvironment = 4, kVerification = 5;

/// Returns the tables of measured errors in what a bake or `multum info` printed.
std::string measured_tables(const std::string& printed);

/// Expects that the program ended with `exit_code`, and that stderr contains all of `parts`.
inline void expect_refusal(const ProgramResult& result, int exit_code, const std::vector<std::string>& parts) {
  EXPECT_EQ(result.exit_code, exit_code) << result.out << result.err;
  expect_says(result.err, parts);
}

/// Base class for tests of `multum` that run commands in a folder of their own. All tests share one cache of compiled
/// kernels in the build folder.
class CliTest : public ::testing::Test {
 protected:
  CliTest();
  static std::vector<std::string> multum_command(std::vector<std::string> arguments);
  /// Runs a command in this process, with the function that main() calls. As in a worker of the service, OpenCL and the
  /// decoding child are already initialized. A command with --threads runs in a process of its own, because a process
  /// cannot change its number of threads later.
  static ProgramResult multum(const std::vector<std::string>& arguments);
  /// Returns whether this build of multum has the command; some builds lack commands
  /// (tools/command_line/absent_commands.h).
  static bool has_command(const std::string& name);
  /// Runs the program multum in its own process.
  static ProgramResult multum_program(const std::vector<std::string>& arguments);
  /// Writes PREFIX_normal.png and PREFIX_albedo.png of the four-quarter map into the folder.
  void make_map(const std::string& prefix, int size);
  std::string path(const std::string& name) const { return folder_ / name; }

  TemporaryFolder folder_;
};

}  // namespace multum::testing
