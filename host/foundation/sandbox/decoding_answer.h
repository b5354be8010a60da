// SPDX-License-Identifier: Apache-2.0
// Messages between a process and the child that decodes files for it, whatever the files are
// (host/foundation/sandbox/decoding_child.h). What a kind of file adds is beside it:
// host/formats/image/files/decoding_messages.h, host/formats/mesh/mesh_messages.h.
//
//   request   DecodingRequest, what it needs    answer   kDone, what was asked for
//             kClose                                     kDone
//             any                                        kRefused, error code, message
//             any                                        kOutOfMemory: it needs more than it is allowed
//             any                                        kNoMemoryHere: it was given less than it is allowed
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

/// File that an answer is about. `memory_max` is what the child was held to.
struct AskedFile {
  std::string path;
  std::string library;  // that the file is expected to survive
  std::uint64_t memory_max;
};

/// Throws Error as the child did; Error(kInput) where the file needs more memory than it is allowed, or its decoding
/// ended in no answer; Error(kEnvironment) where there was less memory than that here.
[[noreturn]] void refuse_as_answered(const AskedFile& file, std::string_view answer);

/// Takes an answer apart by `read(MessageReader&)` where the request was done. Throws Error as above where it was not.
template <typename Read>
auto parse_answer(const AskedFile& file, std::string_view answer, const Read& read) {
  try {
    MessageReader in(answer);
    if (DecodingAnswer{in.number<std::uint8_t>()} == DecodingAnswer::kDone) {
      auto result = read(in);
      if (in.is_at_end()) return result;
    }
  } catch (const std::out_of_range&) {  // cut
  }
  refuse_as_answered(file, answer);
}

/// Whether the system would give this process all that its limit of RLIMIT_DATA still allows: if so, an allocation that
/// failed was beyond the limit. Where it would not, another limit was in the way (of address space, of the machine's
/// memory where the system promises no more than it has), or an administrator's own on RLIMIT_DATA.
bool has_allowed_memory();

/// The child's side: what `work` answers, or its Error as an answer. Memory that ran out is told apart by
/// has_allowed_memory().
std::string answer_or_refusal(const std::function<std::string()>& work);

}  // namespace multum
