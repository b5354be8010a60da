// SPDX-License-Identifier: Apache-2.0
// Messages between a process and the child that decodes files for it, for files of any kind
// (host/foundation/sandbox/decoding_child.h). Further messages of each kind of file are in
// host/formats/image/files/decoding_messages.h and host/formats/mesh/mesh_messages.h.
//
//   request   DecodingRequest, arguments        answer   kDone, result
//             kClose                                     kDone
//             any                                        kRefused, error code, message
//             any                                        kOutOfMemory: decoding needs more than its limit
//             any                                        kNoMemoryHere: the machine has less memory than the limit
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "host/foundation/sandbox/byte_message.h"

namespace multum {

enum class DecodingRequest : std::uint8_t { kClose, kOpenImage, kReadImage, kOpenMesh, kOpenObjects, kReadMesh };
enum class DecodingAnswer : std::uint8_t { kDone, kRefused, kOutOfMemory, kNoMemoryHere };

/// The file that an answer concerns. `memory_max` is the child's memory limit.
struct AskedFile {
  std::string path;
  std::string library;  // the library that decodes the file
  std::uint64_t memory_max;
};

/// Throws the child's Error. Throws Error(kInput) if the file needs more memory than its limit, or if the child ended
/// without a valid answer. Throws Error(kEnvironment) if this machine has less memory than the limit.
[[noreturn]] void refuse_as_answered(const AskedFile& file, std::string_view answer);

/// If the request was done, parses the answer with `read(MessageReader&)`. Otherwise throws Error like
/// refuse_as_answered().
template <typename Read>
auto parse_answer(const AskedFile& file, std::string_view answer, const Read& read) {
  try {
    MessageReader in(answer);
    if (DecodingAnswer{in.number<std::uint8_t>()} == DecodingAnswer::kDone) {
      auto result = read(in);
      if (in.is_at_end()) return result;
    }
  } catch (const std::out_of_range&) {  // the answer is cut short
  }
  refuse_as_answered(file, answer);
}

/// Returns whether the system would give this process all memory that its limit RLIMIT_DATA still allows. If so, a
/// failed allocation exceeded that limit. If not, another limit was reached first. Other limits are the address space,
/// the machine's memory (on systems that do not overcommit), or a lower RLIMIT_DATA that an administrator set.
bool has_allowed_memory();

/// In the child, returns the answer of `work`, or its Error as an answer. If memory is exhausted, has_allowed_memory()
/// decides which answer is returned.
std::string answer_or_refusal(const std::function<std::string()>& work);

}  // namespace multum
