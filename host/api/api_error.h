// SPDX-License-Identifier: Apache-2.0
// Turns exceptions into errors of multum.h. Every function of the interface runs inside guarded().
#pragma once

#include <exception>
#include <string>

#include "host/api/multum.h"
#include "host/foundation/base/error.h"

struct multum_error {
  multum_status status = MULTUM_OK;
  std::string message, file, found, expected;
};

struct multum_text {
  std::string text;
};

namespace multum {

/// Returns the message for callers of the library. It has names of settings instead of options, plain names of images,
/// and no marks of advice.
std::string api_message(const std::string& message);

/// Stores the exception that is being handled in *error, unless `error` is null, and returns the status. Never throws.
multum_status report_exception(multum_error** error) noexcept;

/// Stores an error about a wrong argument or setting.
multum_status report_usage(multum_error** error, const char* message) noexcept;

/// Runs `body`, which throws on failure.
template <typename Body>
multum_status guarded(multum_error** error, const Body& body) noexcept {
  try {
    body();
    return MULTUM_OK;
  } catch (...) {
    return report_exception(error);
  }
}

/// Throws Error(kUsage) if a pointer that a function needs is null, as in "multum_bake: device is NULL, expected a
/// device".
void require(const void* pointer, const char* function, const char* argument, const char* expected);

}  // namespace multum
