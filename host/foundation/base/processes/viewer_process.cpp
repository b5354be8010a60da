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
  if (result.exit_code != 0)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{} failed: {} {} {}:\n{}", what, command.front(),
                            result.signal != 0 ? "was terminated by signal" : "ended with exit code",
                            result.signal != 0 ? result.signal : result.exit_code, result.output));
  log_verbose(result.output);
}

}  // namespace multum
