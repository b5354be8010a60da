// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/workers/fault_injection.h"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"

namespace multum {
namespace {

constexpr double kStep = 0.05;  // seconds between two looks at whether it is cancelled

std::string option(const std::vector<std::string>& arguments, const std::string& name, const std::string& fallback) {
  const std::string start = "--" + name + "=";
  for (const std::string& argument : arguments)
    if (argument.starts_with(start)) return argument.substr(start.size());
  return fallback;
}

}  // namespace

int run_fault_injection(const std::vector<std::string>& arguments, Progress& progress, std::atomic<bool>& is_deaf) {
  const double seconds = std::strtod(option(arguments, "seconds", "0").c_str(), nullptr);
  const std::string then = option(arguments, "then", "succeed");
  const auto steps = static_cast<std::uint64_t>(seconds / kStep);
  progress.start(steps + 1);
  progress.stage("drill");
  for (std::uint64_t step = 0; step < steps; ++step) {
    std::this_thread::sleep_for(std::chrono::duration<double>(kStep));
    progress.advance(1);
  }
  if (then == "fail") throw Error(ErrorCode::kEnvironment, "a drill that was to fail");
  if (then == "refuse") throw Error(ErrorCode::kInput, "a drill that was to be refused");
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

}  // namespace multum
