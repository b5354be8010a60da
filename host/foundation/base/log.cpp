// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/log.h"

#include <cstdio>

#include "host/foundation/base/messages/held_warnings.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/shown_text.h"

namespace multum {
namespace {

LogLevel g_level = LogLevel::kNormal;

void log_line(const std::string& line) { write_shown(stderr, line + "\n"); }

}  // namespace

void set_log_level(LogLevel level) { g_level = level; }
LogLevel log_level() { return g_level; }

void log_warning(const std::string& subject, const std::string& message) {
  log_named_warning(subject + ": " + message);
}
void log_named_warning(const std::string& marked) {
  const std::string warning = with_advice(marked);
  if (HeldWarnings::keep(warning)) return;
  if (g_level != LogLevel::kQuiet) log_line("warning: " + warning);
}
void log_info(const std::string& message) {
  if (g_level != LogLevel::kQuiet) log_line(message);
}
void log_verbose(const std::string& message) {
  if (g_level == LogLevel::kVerbose) log_line(message);
}

}  // namespace multum
