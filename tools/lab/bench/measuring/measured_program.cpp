// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/measuring/measured_program.h"

#include <fmt/format.h>

#include <filesystem>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/child_process.h"
#include "host/foundation/base/stopwatch.h"
#include "tools/lab/bench/measuring/scratch_folder.h"
#include "tools/lab/bench/measuring/statistics.h"

namespace multum::bench {
namespace {

void check_result(const std::string& program, const ChildResult& result, const std::string& output) {
  const std::string said = last_words(result.output);
  if (result.signal != 0)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: terminated by signal {}, expected exit code 0\n{}", program, result.signal, said));
  if (result.exit_code != 0)
    throw Error(result.exit_code == exit_code(ErrorCode::kUsage) ? ErrorCode::kUsage : ErrorCode::kEnvironment,
                fmt::format("{}: exit code {}, expected 0\n{}", program, result.exit_code, said));
  if (!std::filesystem::exists(output))
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: ended with exit code 0, but did not write {}\n{}", program, output, said));
}

nlohmann::ordered_json spread_of_member(const std::vector<ProgramCost>& costs, double ProgramCost::*member) {
  std::vector<double> values;
  for (const ProgramCost& cost : costs) values.push_back(cost.*member);
  return spread_json(spread_of(values));
}

}  // namespace

std::string last_words(const std::string& output) {
  constexpr std::size_t kOutputShown = 2000;
  std::string said = output.substr(output.size() > kOutputShown ? output.size() - kOutputShown : 0);
  while (said.ends_with('\n')) said.pop_back();
  return said;
}

ProgramCost run_to_disk(const std::vector<std::string>& command, const std::string& output, Progress* progress) {
  return run_to_disk(command, std::vector<std::string>{output}, progress);
}

ProgramCost run_to_disk(const std::vector<std::string>& command, const std::vector<std::string>& outputs,
                        Progress* progress) {
  for (const std::string& output : outputs) std::filesystem::remove(output);
  const Stopwatch stopwatch;
  const ChildResult result = run_child(command);
  progress_advance(progress, 0);  // Ctrl-C also terminates the child, which does not count as a failure of the child
  for (const std::string& output : outputs) {
    check_result(command[0], result, output);
    sync_file(output);
  }
  const double wall = stopwatch.seconds();
  double bytes = 0.0;
  for (const std::string& output : outputs) bytes += static_cast<double>(std::filesystem::file_size(output));
  return {wall, result.usage.cpu_seconds(), static_cast<double>(result.usage.peak_memory_bytes) / (1 << 20),
          bytes / 1e6};
}

nlohmann::ordered_json costs_json(const std::vector<ProgramCost>& costs) {
  return {{"wall_s", spread_of_member(costs, &ProgramCost::wall_seconds)},
          {"cpu_s", spread_of_member(costs, &ProgramCost::cpu_seconds)},
          {"peak_mib", spread_of_member(costs, &ProgramCost::peak_mib)},
          {"output_mb", spread_of_member(costs, &ProgramCost::output_mb)}};
}

}  // namespace multum::bench
