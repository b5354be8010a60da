// SPDX-License-Identifier: Apache-2.0
// States what this code may do to the process that it runs in. A program owns its process: it sets environment
// variables for drivers, writes its log to stderr, and stops after a programming error. A library may not do any of
// this in the process that loads it. Each binary links one implementation: program_rules.cpp, or
// host/api/library_rules.cpp for libmultum.
#pragma once

#include <string>

namespace multum {

/// Sets an environment variable that makes a driver faster. If `replace` is false, an existing value is kept. Returns
/// whether the variable now has the value. In the library, the result is false, because the library never changes the
/// environment.
bool prefer_environment(const char* name, const std::string& value, bool replace);

/// Sets an environment variable without which a driver would end the process, unless the variable is already set. The
/// library instead throws Error(kEnvironment), which names the variable, the value and `reason`.
void require_environment(const char* name, const std::string& value, const std::string& reason);

/// Writes a line of the log to stderr. The library discards the line, because each call of the library has its own
/// listener (host/foundation/base/messages/log_listener.h).
void show_log_line(const std::string& line);

/// Returns the folder with the programs of the same build. For a program, this is the folder of the running program.
/// For the library, it is the folder that contains multum-decode.
std::string program_folder();

/// Handles a failed MULTUM_CHECK. The program prints the place in the source and aborts. The library throws
/// std::logic_error, which becomes an error of the call.
[[noreturn]] void check_failed(const char* condition, const char* file, int line);

}  // namespace multum
