// SPDX-License-Identifier: Apache-2.0
// The program multum-decode is the child process in which multum and multum-view read images and meshes
// (host/foundation/sandbox/decoding_child.h). Users cannot run it themselves, because it receives its requests through
// an inherited socket.
#include <cstdio>

#include "host/formats/decoder/image_decoder.h"
#include "host/formats/decoder/mesh_decoder.h"
#include "host/foundation/base/error.h"
#include "host/foundation/sandbox/helper_service.h"

namespace multum {
namespace {

class Decoder {
 public:
  std::string answer(std::string_view request, SharedMemory& memory) {
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

 private:
  ImageDecoder images_;
  MeshDecoder meshes_;
};

int run(int, char**) {
  Decoder decoder;
  const int exit_code = serve_helper([&](std::string_view request, SharedMemory& memory) {
    return answer_or_refusal([&] { return decoder.answer(request, memory); });
  });
  if (exit_code != 0)
    std::fputs("multum-decode: found no request socket; multum and multum-view start this program to read files\n",
               stderr);
  return exit_code;
}

}  // namespace
}  // namespace multum

int main(int argc, char** argv) { return multum::run_guarded("multum-decode", multum::run, argc, argv); }
