// SPDX-License-Identifier: Apache-2.0
// Decodes files whose libraries die on some of them in a child process (tools/multum_decode), which hands numbers over
// in memory that both see. A child that has read a file to its end reads the next one; one that has failed is gone, and
// a file's failure is no other file's. How much a file may take is its kind's to say:
// host/formats/image/files/child_image_file.cpp, host/formats/mesh/mesh_source.cpp.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "host/foundation/sandbox/decoding_answer.h"
#include "host/foundation/sandbox/helper_process.h"

namespace multum {

/// multum-decode in the folder of the running program: it must be of the same build, nothing is looked for in PATH.
std::string decoder_beside_this_program();

/// Limits of a child for one request: these, and more for larger files.
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

  /// Requests from here on may take so much more than the base.
  void allow(std::uint64_t more_memory, std::chrono::seconds more_time);
  SharedMemory& memory() { return process_->memory(); }
  AskedFile asked() const { return {path_, library_, limits_.memory_max}; }

  /// The answer's content by `read(MessageReader&)`. Throws Error that names the file, whatever becomes of the child.
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
