// SPDX-License-Identifier: Apache-2.0
// Implements the rules for programs, which own their process.
#include "host/foundation/base/process_rules/process_rules.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/shown_text.h"

namespace multum {

bool prefer_environment(const char* name, const std::string& value, bool replace) {
  return ::setenv(name, value.c_str(), replace ? 1 : 0) == 0;
}

void require_environment(const char* name, const std::string& value, const std::string&) {
  prefer_environment(name, value, false);
}

void show_log_line(const std::string& line) { write_shown(stderr, line + "\n"); }

std::string program_folder() { return std::filesystem::path(own_program()).parent_path().string(); }

void check_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: check failed: %s\n", file, line, condition);
  std::abort();
}

}  // namespace multum
