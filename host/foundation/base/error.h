// SPDX-License-Identifier: Apache-2.0
// The three kinds of errors, which are handled in different ways (docs/contributing/ARCHITECTURE.md, "Errors"):
//   programmer error      MULTUM_CHECK and MULTUM_DCHECK stop the program;
//   bad input or machine  the code throws Error{code, message}, which says which file, what was found, what was
//   expected;
//   numerical trouble     a documented rule clamps the value, and the report counts it; nothing is thrown.
#pragma once

#include <exception>
#include <stdexcept>
#include <string>

namespace multum {

enum class ErrorCode {
  kUsage,         // the command line or a setting is wrong
  kInput,         // a given file cannot be used because it is missing, damaged or of the wrong kind
  kEnvironment,   // the machine cannot do the work at present (device, driver, disk, memory)
  kVerification,  // a check of a finished file failed
};

class Error : public std::runtime_error {
 public:
  /// If the message contains a path through a descriptor of this process (such as the path of a working folder), the
  /// path is replaced by the name of the open file.
  Error(ErrorCode code, const std::string& message);
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

/// Thrown at the next tile boundary after a Progress callback asked to stop. No partial file remains on the disk.
class Cancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

/// Returns the exit code of a program that ends with this error: 2 for usage, 3 for input, 4 for the environment, 5 for
/// verification.
int exit_code(ErrorCode code);

/// Runs `body`. Maps every exception to a message on stderr ("PROGRAM: message") and an exit code (130 for Cancelled).
/// Exceptions are caught only here, in the daemon's jobs and at the C boundary.
int run_guarded(const char* program, int (*body)(int, char**), int argc, char** argv);

/// Throws Error{kInput} with the message "PATH: WHAT".
[[noreturn]] void refuse_file(const std::string& path, const std::string& what);

/// Throws Error{kEnvironment} with the message "SUBJECT: WHAT: " and the meaning of errno. The subject is a path or
/// another object that the failed call used.
[[noreturn]] void fail_by_errno(const std::string& subject, const std::string& what);

/// This function is implemented in host/foundation/base/process_rules.
[[noreturn]] void check_failed(const char* condition, const char* file, int line);

}  // namespace multum

/// Stops the program if `condition` is false, also in release builds. Use it only for programming errors, never for bad
/// input.
#define MULTUM_CHECK(condition) \
  ((condition) ? static_cast<void>(0) : ::multum::check_failed(#condition, __FILE__, __LINE__))

#ifdef MULTUM_DEBUG_CHECKS
#define MULTUM_DCHECK(condition) MULTUM_CHECK(condition)
#else
#define MULTUM_DCHECK(condition) static_cast<void>(0)
#endif
