// SPDX-License-Identifier: Apache-2.0
// The module multum-decode-libraries.so decodes files with OpenImageIO and assimp
// (host/formats/decoder/libraries/decoder_module.h).
#include "host/formats/decoder/image_decoder.h"
#include "host/formats/decoder/libraries/decoder_module.h"
#include "host/formats/decoder/libraries/mesh_decoder.h"
#include "host/formats/decoder/libraries/oiio_image_file.h"
#include "host/foundation/sandbox/decoding_answer.h"

namespace multum {
namespace {

class Module : public DecoderModule {
 public:
  std::string answer(std::string_view request, SharedMemory& memory) override {
    return answer_or_refusal([&] { return answer_or_throw(request, memory); });
  }

 private:
  std::string answer_or_throw(std::string_view request, SharedMemory& memory) {
    MessageReader in(request);
    switch (DecodingRequest{in.number<std::uint8_t>()}) {
      case DecodingRequest::kOpenMesh:
      case DecodingRequest::kOpenObjects:
      case DecodingRequest::kReadMesh: return meshes_.answer(request, memory);
      case DecodingRequest::kOpenImage:
      case DecodingRequest::kReadImage: return images_.answer(request, memory);
      case DecodingRequest::kClose: break;
    }
    images_.close();
    meshes_.close();
    return MessageWriter().number(DecodingAnswer::kDone).take();
  }

  ImageDecoder images_{open_oiio_image};
  MeshDecoder meshes_;
};

}  // namespace
}  // namespace multum

extern "C" __attribute__((visibility("default"))) multum::DecoderModule* multum_decoder_module() {
  static multum::Module module;
  return &module;
}
