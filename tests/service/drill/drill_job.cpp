// SPDX-License-Identifier: Apache-2.0
#include "tests/service/drill/drill_job.h"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/progress.h"

namespace multum {
namespace {

constexpr double kStep = 0.05;  // the number of seconds between two checks for cancellation

std::string option(const std::vector<std::string>& arguments, const std::string& name, const std::string& fallback) {
  const std::string start = "--" + name + "=";
  for (const std::string& argument : arguments)
    if (argument.starts_with(start)) return argument.substr(start.size());
  return fallback;
}

const ParameterTable& drill_parameters() {
  static const ParameterTable table(
      "drill",
      {{.name = "seconds",
        .kind = ParameterKind::kNumber,
        .help = "duration",
        .low = 0,
        .high = 86400,
        .unit = "s",
        .surfaces = kInService},
       {.name = "then",
        .kind = ParameterKind::kChoice,
        .help = "end of the job: success, an error that may be tried again, a final error, a crash, or no end: without "
                "a heartbeat, or without progress",
        .choices = {"succeed", "fail", "refuse", "crash", "hang", "stall"},
        .surfaces = kInService},
       {.name = "text", .kind = ParameterKind::kText, .help = "text to write to the output", .surfaces = kInService}});
  return table;
}

// With `is_deaf`, the job hangs without a heartbeat.
int run_drill(const std::vector<std::string>& arguments, Progress& progress, std::atomic<bool>& is_deaf) {
  const double seconds = std::strtod(option(arguments, "seconds", "0").c_str(), nullptr);
  const std::string then = option(arguments, "then", "succeed");
  const auto steps = static_cast<std::uint64_t>(seconds / kStep);
  progress.start(steps + 1);
  progress.stage("drill");
  for (std::uint64_t step = 0; step < steps; ++step) {
    std::this_thread::sleep_for(std::chrono::duration<double>(kStep));
    progress.advance(1);
  }
  if (then == "fail") throw Error(ErrorCode::kEnvironment, "this drill had to fail");
  if (then == "refuse") throw Error(ErrorCode::kInput, "this drill had to be refused");
  if (then == "crash") std::raise(SIGKILL);
  if (then == "hang" || then == "stall") {
    is_deaf = then == "hang";
    for (;;) std::this_thread::sleep_for(std::chrono::seconds(1));
  }
  if (const std::string output = option(arguments, "output", ""); !output.empty())
    write_text_file(output, option(arguments, "text", "") + "\n");
  progress.finish();
  std::printf("drill: done\n");
  return 0;
}

double seconds_of_drill(const nlohmann::json& parameters) { return parameters.value("seconds", 0.0); }

}  // namespace

JobType drill_job_type() {
  return {.name = "drill",
          .summary = "do nothing, or fail as the parameters say; for tests of queues, limits and alarms",
          .run = run_drill,
          .needs_output = false,
          .table = &drill_parameters(),
          .estimated_seconds = seconds_of_drill};
}

}  // namespace multum
