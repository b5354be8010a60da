// SPDX-License-Identifier: Apache-2.0
// Decodes files in a child process (tools/multum_decode), because libraries crash on some files. The child returns
// numbers in shared memory. A child that has read a whole file is used again for the next file. A child that failed is
// replaced, so a failure for one file never affects another file. Each kind of file sets its own limits
// (host/formats/image/files/child_image_file.cpp, host/formats/mesh/mesh_source.cpp).
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "host/foundation/sandbox/decoding_answer.h"
#include "host/foundation/sandbox/helper_process.h"

namespace multum {

/// Returns the path of multum-decode, which is in the folder of the running program, or in PREFIX/libexec/multum for a
/// program in PREFIX/bin. Both programs must be of the same build, so PATH is not searched.
std::string decoder_beside_this_program();

/// The basic limits of a child for one request. They are raised for larger files.
struct DecodingChild {
  std::string program = decoder_beside_this_program();
  std::uint64_t memory_base = std::uint64_t{1} << 30;  // bytes
  int time_base_ms = 30000;
};

/// A file and the child that decodes it.
class DecodedFile {
 public:
  DecodedFile(DecodingChild child, std::string path, std::string library);
  ~DecodedFile();
  DecodedFile(const DecodedFile&) = delete;
  DecodedFile& operator=(const DecodedFile&) = delete;

  /// Adds memory and time to the base limits of later requests.
  void allow(std::uint64_t more_memory, std::chrono::seconds more_time);
  SharedMemory& memory() { return process_->memory(); }
  AskedFile asked() const { return {path_, library_, limits_.memory_max}; }

  /// Returns the answer after parsing it with `read(MessageReader&)`. If the child fails in any way, throws Error,
  /// which names the file.
  template <typename Read>
  auto ask(const std::string& request, const Read& read, const std::function<void()>& while_waiting = {}) {
    return parse_answer(asked(), answer(request, while_waiting), read);
  }

 private:
  std::string answer(const std::string& request, const std::function<void()>& while_waiting);

  DecodingChild child_;
  std::string path_, library_;
  std::unique_ptr<HelperProcess> process_;
  HelperLimits limits_;
};

}  // namespace multum
