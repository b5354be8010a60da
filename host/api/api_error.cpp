// SPDX-License-Identifier: Apache-2.0
#include "host/api/api_error.h"

#include <new>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "host/foundation/base/files/memory_images.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/base/system_failure.h"

namespace multum {
namespace {

// This error is made in advance, because no error can be made when memory has run out. multum_error_free() ignores it.
multum_error& no_memory() {
  static multum_error error{MULTUM_OUT_OF_MEMORY, "out of memory", "", "", ""};
  return error;
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); }

// Writes "first_level" for "--first-level".
std::string with_setting_names(const std::string& message) {
  std::string text;
  for (std::size_t i = 0; i < message.size(); ++i) {
    const bool begins = message.compare(i, 2, "--") == 0 && i + 2 < message.size() && is_letter(message[i + 2]) &&
                        (i == 0 || message[i - 1] == ' ' || message[i - 1] == '(');
    if (!begins) {
      text += message[i];
      continue;
    }
    for (i += 2; i < message.size() && (is_letter(message[i]) || message[i] == '-'); ++i)
      text += message[i] == '-' ? '_' : message[i];
    --i;
  }
  return text;
}

multum_status status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage: return MULTUM_BAD_SETTING;
    case ErrorCode::kInput: return MULTUM_BAD_INPUT;
    case ErrorCode::kEnvironment: return MULTUM_BAD_ENVIRONMENT;
    case ErrorCode::kVerification: return MULTUM_NOT_VERIFIED;
  }
  return MULTUM_INTERNAL;
}

// Messages have the form "FILE: found X, expected Y. Advice" or "NAME is X, expected Y".
void take_parts(multum_error& error) {
  const std::string& text = error.message;
  std::size_t expected = text.find("expected ");
  while (expected != std::string::npos && expected > 0 && is_letter(text[expected - 1]))  // "unexpected "
    expected = text.find("expected ", expected + 1);
  const std::size_t colon = text.find(": ");
  const bool has_file = error.status != MULTUM_BAD_SETTING && colon != std::string::npos && colon < expected;
  if (has_file) error.file = text.substr(0, colon);
  if (expected != std::string::npos) {
    const std::size_t begin = expected + 9;
    std::size_t end = begin;
    while (end < text.size() && text[end] != ';' &&
           !(text[end] == '.' && (end + 1 == text.size() || text[end + 1] == ' ')))
      ++end;
    error.expected = text.substr(begin, end - begin);
  }
  const std::size_t limit = expected == std::string::npos ? text.size() : expected;
  for (const std::string word : {"found ", " is "}) {
    const std::size_t at = text.find(word, has_file ? colon : 0);
    if (at == std::string::npos || at >= limit) continue;
    const std::size_t begin = at + word.size();
    error.found = text.substr(begin, text.find_first_of(",;:", begin) - begin);
    break;
  }
}

multum_status store(multum_error** error, multum_status status, const std::string& message) noexcept {
  if (error == nullptr) return status;
  try {
    auto* const made = new multum_error{status, api_message(message), "", "", ""};
    *error = made;
    take_parts(*made);
  } catch (...) {
    if (*error == nullptr) *error = &no_memory();
    return (*error)->status;
  }
  return status;
}

}  // namespace

std::string api_message(const std::string& message) {
  return with_plain_image_names(with_setting_names(with_advice(message)));
}

multum_status report_exception(multum_error** error) noexcept {
  if (error != nullptr) *error = nullptr;
  try {
    throw;
  } catch (const Cancelled&) {
    return store(error, MULTUM_CANCELLED, "cancelled; no unfinished files remain");
  } catch (const Error& caught) {
    return store(error, status_of(caught.code()), caught.what());
  } catch (const std::bad_alloc&) {
    if (error != nullptr) *error = &no_memory();
    return MULTUM_OUT_OF_MEMORY;
  } catch (const std::system_error&) {
    try {
      return store(error, MULTUM_BAD_ENVIRONMENT, caught_error("").what());
    } catch (...) {
      return store(error, MULTUM_BAD_ENVIRONMENT, "a system call failed");
    }
  } catch (const std::exception& caught) {
    return store(error, MULTUM_INTERNAL, caught.what());
  } catch (...) {
    return store(error, MULTUM_INTERNAL, "unknown exception");
  }
}

multum_status report_usage(multum_error** error, const char* message) noexcept {
  if (error != nullptr) *error = nullptr;
  return store(error, MULTUM_BAD_SETTING, message);
}

void require(const void* pointer, const char* function, const char* argument, const char* expected) {
  if (pointer == nullptr)
    throw Error(ErrorCode::kUsage, std::string(function) + ": " + argument + " is NULL, expected " + expected);
}

}  // namespace multum

multum_status multum_error_status(const multum_error* error) { return error == nullptr ? MULTUM_OK : error->status; }
const char* multum_error_message(const multum_error* error) { return error == nullptr ? "" : error->message.c_str(); }
const char* multum_error_file(const multum_error* error) { return error == nullptr ? "" : error->file.c_str(); }
const char* multum_error_found(const multum_error* error) { return error == nullptr ? "" : error->found.c_str(); }
const char* multum_error_expected(const multum_error* error) { return error == nullptr ? "" : error->expected.c_str(); }
void multum_error_free(multum_error* error) {
  if (error != &multum::no_memory()) delete error;
}

const char* multum_version(void) { return MULTUM_VERSION; }

const char* multum_text_get(const multum_text* text) { return text == nullptr ? "" : text->text.c_str(); }
void multum_text_free(multum_text* text) { delete text; }
