// SPDX-License-Identifier: Apache-2.0
#include "host/base/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "host/base/held_warnings.h"
#include "host/base/shown_text.h"

namespace multum {
namespace {

LogLevel g_level = LogLevel::kNormal;

spdlog::logger& logger() {
  static auto instance = [] {
    auto made = spdlog::stderr_logger_mt("multum");
    made->set_pattern("%v");
    made->set_level(spdlog::level::debug);
    return made;
  }();
  return *instance;
}

// Messages name files.
std::string for_stderr(const std::string& message) {
  return isatty(STDERR_FILENO) != 0 ? shown_text(message) : message;
}

}  // namespace

void set_log_level(LogLevel level) { g_level = level; }
LogLevel log_level() { return g_level; }

void log_warning(const std::string& message) {
  if (HeldWarnings::keep(message)) return;
  if (g_level != LogLevel::kQuiet) logger().warn("warning: {}", for_stderr(message));
}
void log_info(const std::string& message) {
  if (g_level != LogLevel::kQuiet) logger().info("{}", for_stderr(message));
}
void log_verbose(const std::string& message) {
  if (g_level == LogLevel::kVerbose) logger().debug("{}", for_stderr(message));
}

}  // namespace multum
