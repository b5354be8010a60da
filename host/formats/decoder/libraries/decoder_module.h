// SPDX-License-Identifier: Apache-2.0
// The interface of multum-decode-libraries.so, which multum-decode loads when a file needs OpenImageIO or assimp. Most
// maps do not need these libraries. Loading them takes a quarter of a second of processor time.
#pragma once

#include <string>
#include <string_view>

#include "host/foundation/sandbox/shared_memory.h"

namespace multum {

class DecoderModule {
 public:
  virtual ~DecoderModule() = default;
  /// Answers a request of host/formats/image/files/decoding_messages.h or host/formats/mesh/mesh_messages.h. A failure
  /// is answered as a refusal. No exception leaves the module.
  virtual std::string answer(std::string_view request, SharedMemory& memory) = 0;
};

/// Returns the module's only decoder.
using GetDecoderModule = DecoderModule* (*)();
inline constexpr char kGetDecoderModule[] = "multum_decoder_module";
inline constexpr char kDecoderModuleFile[] = "multum-decode-libraries.so";

}  // namespace multum
