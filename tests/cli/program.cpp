// SPDX-License-Identifier: Apache-2.0
// See program.h.
#include "tests/cli/program.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "host/foundation/base/log.h"
#include "tools/multum/commands.h"

namespace multum::testing {
namespace {

const std::regex kOptionName("--[a-z][a-z0-9-]*[a-z0-9]");

[[noreturn]] void become(const std::vector<std::string>& arguments) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execvp(argv[0], argv.data());
  _exit(127);
}

// Redirects stdout or stderr to a file.
class Redirection {
 public:
  Redirection(std::FILE* stream, const std::string& path) : stream_(stream) {
    std::fflush(stream_);
    const int file = open(path.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
    usual_ = fcntl(fileno(stream_), F_DUPFD_CLOEXEC, 0);
    dup2(file, fileno(stream_));
    close(file);
  }
  ~Redirection() {
    std::fflush(stream_);
    dup2(usual_, fileno(stream_));
    close(usual_);
  }
  Redirection(const Redirection&) = delete;
  Redirection& operator=(const Redirection&) = delete;

 private:
  std::FILE* stream_;
  int usual_ = -1;
};

}  // namespace

Program::Program(const std::vector<std::string>& arguments) {
  pid_ = fork();
  if (pid_ == 0) {
    dup2(open((folder_ / "out").c_str(), O_CREAT | O_WRONLY, 0600), STDOUT_FILENO);
    dup2(open((folder_ / "err").c_str(), O_CREAT | O_WRONLY, 0600), STDERR_FILENO);
    become(arguments);
  }
  EXPECT_GT(pid_, 0);
}

Program::~Program() {
  if (ended_) return;
  kill(pid_, SIGKILL);
  wait();
}

void Program::send(int signal) const {
  if (!ended_) kill(pid_, signal);
}

std::string Program::err_so_far() const {
  return std::filesystem::exists(folder_ / "err") ? read_bytes(folder_ / "err") : "";
}

void Program::remember(int status) {
  ended_ = true;
  if (WIFEXITED(status)) result_.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result_.signal = WTERMSIG(status);
}

bool Program::running() {
  int status = 0;
  if (!ended_ && waitpid(pid_, &status, WNOHANG) == pid_) remember(status);
  return !ended_;
}

ProgramResult Program::wait() {
  int status = 0;
  while (!ended_) {
    if (waitpid(pid_, &status, 0) == pid_) remember(status);
    else if (errno != EINTR) break;
  }
  result_.out = read_bytes(folder_ / "out");
  result_.err = read_bytes(folder_ / "err");
  return result_;
}

ProgramResult run_program(const std::vector<std::string>& arguments) { return Program(arguments).wait(); }

bool has_pseudo_terminals() {
  int terminal = -1, program_side = -1;
  if (openpty(&terminal, &program_side, nullptr, nullptr, nullptr) != 0) return false;
  close(terminal);
  close(program_side);
  return true;
}

ProgramResult run_on_terminal(const std::vector<std::string>& arguments) {
  int terminal = -1;
  const pid_t pid = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (pid == 0) become(arguments);
  ProgramResult result;
  if (pid < 0) {
    ADD_FAILURE() << "no pseudo terminal";
    return result;
  }
  std::array<char, 4096> buffer;
  for (;;) {  // Linux reports EIO when the program has ended, which ends this loop
    const ssize_t count = read(terminal, buffer.data(), buffer.size());
    if (count > 0) result.out.append(buffer.data(), static_cast<std::size_t>(count));
    else if (count == 0 || errno != EINTR) break;
  }
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  close(terminal);
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  return result;
}

bool program_works(const std::string& program, const std::string& argument) {
  return run_program({program, argument}).exit_code == 0;
}

std::string chromium_path() {
  for (const std::string name : {"chromium-headless-shell", "chromium"})
    for (const std::string folder : {"/usr/bin/", "/usr/local/bin/"})
      if (std::filesystem::exists(folder + name)) return folder + name;
  return "";
}

CliTest::CliTest() { setenv("MULTUM_CACHE_DIR", MULTUM_TEST_CACHE, 1); }

std::vector<std::string> CliTest::multum_command(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), std::string(MULTUM_BIN_DIR) + "/multum");
  return arguments;
}

namespace {

// All tests check messages against two rules. A warning begins with its subject, which is a file or a library. A
// message names only options of the command that was run. If it names an option of another program or command, the name
// of that program or command comes first.
const std::set<std::string>& options_in_help(const std::string& command) {
  static std::map<std::string, std::set<std::string>> known;
  const auto [place, is_new] = known.emplace(command, std::set<std::string>());
  if (!is_new) return place->second;
  const std::string help = run_program({std::string(MULTUM_BIN_DIR) + "/multum", command, "--help"}).out;
  for (std::sregex_iterator at(help.begin(), help.end(), kOptionName), end; at != end; ++at)
    place->second.insert(at->str());
  return place->second;
}

void check_message(const std::vector<std::string>& arguments, const std::string& line) {
  static const std::regex other_command("multum(-view)? [a-z-]+|maketx ");
  if (line.starts_with("warning: ")) {
    const std::string subject = line.substr(9, line.find(": ", 9) - 9);
    EXPECT_TRUE(subject.find_first_of("/.") != std::string::npos || subject == "OpenCL" || subject == "GL")
        << "this warning names no file: " << line;
  }
  std::string given;
  for (const std::string& argument : arguments) given += argument + " ";
  for (std::sregex_iterator at(line.begin(), line.end(), kOptionName), end; at != end; ++at) {
    if (given.find(at->str()) != std::string::npos || options_in_help(arguments[0]).contains(at->str())) continue;
    EXPECT_TRUE(std::regex_search(line.substr(0, static_cast<std::size_t>(at->position())), other_command))
        << "multum " << arguments[0] << " has no " << at->str() << ": " << line;
  }
}

void check_messages(const std::vector<std::string>& arguments, const std::string& err) {
  if (arguments.empty() || arguments[0].starts_with("-")) return;
  std::istringstream lines(err);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("multum: ") || line.starts_with("warning: ")) check_message(arguments, line);
}

[[maybe_unused]] const bool kHasJobs = (register_jobs(), true);  // registers the jobs before any command runs

}  // namespace

ProgramResult CliTest::multum_program(const std::vector<std::string>& arguments) {
  ProgramResult result = run_program(multum_command(arguments));
  check_messages(arguments, result.err);
  return result;
}

ProgramResult CliTest::multum(const std::vector<std::string>& arguments) {
  if (std::find(arguments.begin(), arguments.end(), "--threads") != arguments.end()) return multum_program(arguments);
  std::vector<std::string> words = {"multum"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  const TemporaryFolder folder;
  ProgramResult result;
  {
    const Redirection out(stdout, folder / "out"), err(stderr, folder / "err");
    set_log_level(LogLevel::kNormal);  // an earlier command may have set --quiet
    result.exit_code = run_guarded("multum", run_command, static_cast<int>(argv.size()), argv.data());
  }
  result.out = read_bytes(folder / "out");
  result.err = read_bytes(folder / "err");
  check_messages(arguments, result.err);
  return result;
}

bool CliTest::has_command(const std::string& name) { return multum({name, "--help"}).exit_code == 0; }

void CliTest::make_map(const std::string& prefix, int size) {
  const ProgramResult made = multum({"testmap", path(prefix), "--size", std::to_string(size)});
  ASSERT_EQ(made.exit_code, 0) << made.err;
}

std::string measured_tables(const std::string& printed) {
  const std::string heading = "measured error";
  std::string tables;
  std::istringstream lines(printed);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(heading) || (!tables.empty() && line.starts_with("  "))) tables += line + "\n";
    else if (!tables.empty()) break;
  return tables;
}

}  // namespace multum::testing
