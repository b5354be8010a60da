// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/log.h"

#include "host/foundation/base/messages/held_warnings.h"
#include "host/foundation/base/messages/log_listener.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/process_rules/process_rules.h"

namespace multum {
namespace {

LogLevel g_level = LogLevel::kNormal;

// If there is a listener, it receives all lines. The log level only limits lines that have no listener.
void log_line(LogKind kind, const std::string& line, bool is_shown) {
  if (LogListener* const listener = log_receivers().listener) listener->hear(kind, line);
  else if (is_shown) show_log_line(kind == LogKind::kWarning ? "warning: " + line : line);
}

}  // namespace

void set_log_level(LogLevel level) { g_level = level; }
LogLevel log_level() { return g_level; }

void log_warning(const std::string& subject, const std::string& message) {
  log_named_warning(subject + ": " + message);
}
void log_named_warning(const std::string& marked) {
  const std::string warning = with_advice(marked);
  if (HeldWarnings::keep(warning)) return;
  log_line(LogKind::kWarning, warning, g_level != LogLevel::kQuiet);
}
void log_info(const std::string& message) { log_line(LogKind::kInfo, message, g_level != LogLevel::kQuiet); }
void log_verbose(const std::string& message) { log_line(LogKind::kVerbose, message, g_level == LogLevel::kVerbose); }

LogReceivers& log_receivers() {
  static thread_local LogReceivers receivers;
  return receivers;
}

}  // namespace multum
