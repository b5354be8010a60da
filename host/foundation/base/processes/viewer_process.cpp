// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/processes/viewer_process.h"

#include <fmt/format.h>

#include <csignal>
#include <filesystem>
#include <system_error>

#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/process_rules/process_rules.h"
#include "host/foundation/base/processes/child_process.h"

namespace multum {
namespace {

// run_guarded() writes this before the error of multum-view, which is the last output of the program.
constexpr const char* kErrorMark = "multum-view: ";

// Throws the viewer's own error if it concerns a file: the caller then names this file and keeps the kind of error.
void relay_file_error(const ChildResult& result) {
  for (const ErrorCode code : {ErrorCode::kInput, ErrorCode::kVerification}) {
    if (result.exit_code != exit_code(code)) continue;
    const std::size_t line = ("\n" + result.output).rfind(std::string("\n") + kErrorMark);
    if (line == std::string::npos) return;
    std::string text = result.output.substr(line + std::string(kErrorMark).size());
    text.erase(text.find_last_not_of('\n') + 1);
    throw Error(code, text);
  }
}

}  // namespace

std::string find_viewer() {
  std::error_code error;
  const std::string installed = program_folder() + "/multum-view";
  return std::filesystem::exists(installed, error) ? installed : "multum-view";
}

void run_viewer(const std::vector<std::string>& command, const std::string& what, Progress* progress) {
  const ChildResult result = run_child(command);
  progress_advance(progress, 0);
  // Ctrl-C, and a SIGTERM that is sent to the group, reach both processes. The viewer can end before this process
  // notices the signal.
  if (result.signal == SIGINT || result.signal == SIGTERM) throw Cancelled();
  relay_file_error(result);
  if (result.exit_code != 0)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{} failed: {} {} {}:\n{}", what, command.front(),
                            result.signal != 0 ? "was terminated by signal" : "ended with exit code",
                            result.signal != 0 ? result.signal : result.exit_code, result.output));
  log_verbose(result.output);
}

}  // namespace multum
