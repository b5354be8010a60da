// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/sandbox/decoding_answer.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstdio>
#include <new>

#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/system_failure.h"
#include "host/foundation/sandbox/damaged_file.h"

namespace multum {
namespace {

// Throws the error that an answer contains, or std::out_of_range if the answer is cut. Returns if there is no error.
void throw_refusal(const AskedFile& file, std::string_view answer) {
  MessageReader in(answer);
  const DecodingAnswer kind{in.number<std::uint8_t>()};
  if (kind == DecodingAnswer::kRefused) {
    const auto code = in.number<std::uint8_t>();
    throw Error(code <= static_cast<std::uint8_t>(ErrorCode::kVerification) ? ErrorCode{code} : ErrorCode::kInput,
                in.text());
  }
  if (kind == DecodingAnswer::kOutOfMemory)
    throw Error(
        ErrorCode::kInput,
        fmt::format("{}: decoding needs more than {} bytes of memory, expected a file that needs less{}", file.path,
                    file.memory_max, advice(" (<decode child:SECONDS,MEMORY> allows more, for files that you trust)")));
  if (kind == DecodingAnswer::kNoMemoryHere)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: not enough memory to decode it: less than its limit of {} bytes is available. Use a "
                            "machine, a container or limits (ulimit -v) that allow more: {}",
                            file.path, file.memory_max, errno_text(ENOMEM)));
}

// Returns the number of bytes that RLIMIT_DATA counts.
std::uint64_t data_bytes() {
  std::FILE* const file = std::fopen("/proc/self/statm", "re");
  if (file == nullptr) return 0;
  unsigned long data = 0;
  const int found = std::fscanf(file, "%*u %*u %*u %*u %*u %lu", &data);
  std::fclose(file);
  return found == 1 ? std::uint64_t{data} * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

// Libraries report exhausted memory in different words: "Insufficient memory", "Cannot allocate", "std::bad_alloc".
bool speaks_of_memory(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text.find("memory") != std::string::npos || text.find("alloc") != std::string::npos;
}

std::string no_memory() {
  const DecodingAnswer kind = has_allowed_memory() ? DecodingAnswer::kOutOfMemory : DecodingAnswer::kNoMemoryHere;
  return MessageWriter().number(kind).take();
}

}  // namespace

void refuse_as_answered(const AskedFile& file, std::string_view answer) {
  try {
    throw_refusal(file, answer);
  } catch (const std::out_of_range&) {  // the answer is not a valid refusal either
  }
  throw Error(ErrorCode::kInput, fmt::format("{}: decoding returned {} invalid bytes, expected an undamaged "
                                             "file that {} can read",
                                             file.path, answer.size(), file.library));
}

bool has_allowed_memory() {
  rlimit limit = {};
  if (::getrlimit(RLIMIT_DATA, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return true;
  if (limit.rlim_cur == limit.rlim_max) return false;       // the parent could not set the intended limit
  constexpr std::uint64_t kSlack = std::uint64_t{4} << 20;  // margin for the C library's own allocations
  const std::uint64_t taken = data_bytes() + kSlack;
  if (limit.rlim_cur <= taken) return true;
  const std::size_t rest = limit.rlim_cur - taken;
  void* const memory = ::mmap(nullptr, rest, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return false;
  ::munmap(memory, rest);
  return true;
}

std::string answer_or_refusal(const std::function<std::string()>& work) {
  try {
    return work();
  } catch (const NotEnoughMemory&) {
    return no_memory();
  } catch (const std::bad_alloc&) {
    return no_memory();
  } catch (const Error& error) {
    if (speaks_of_memory(error.what()) && !has_allowed_memory()) return no_memory();
    return MessageWriter()
        .number(DecodingAnswer::kRefused)
        .number(static_cast<std::uint8_t>(error.code()))
        .text(error.what())
        .take();
  }
}

}  // namespace multum
