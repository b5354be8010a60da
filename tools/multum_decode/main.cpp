// SPDX-License-Identifier: Apache-2.0
// The program multum-decode is the child process in which multum and multum-view read images and meshes
// (host/foundation/sandbox/decoding_child.h). Users cannot run it themselves, because it receives its requests through
// an inherited socket.
#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "host/formats/decoder/image_decoder.h"
#include "host/formats/decoder/libraries/decoder_module.h"
#include "host/formats/decoder/zlib_uncompress.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/process_rules/process_rules.h"
#include "host/foundation/sandbox/decoding_answer.h"
#include "host/foundation/sandbox/helper_service.h"

namespace multum {
namespace {

// The exit code of a program whose libraries cannot be loaded (ld.so).
constexpr int kNotLoaded = 127;

// Loads the module. Throws Error(kEnvironment) if it is missing. If it cannot be loaded, ends this process like a
// program whose libraries are missing.
DecoderModule* load_module() {
  const std::string path = program_folder() + "/" + kDecoderModuleFile;
  if (std::error_code ignored; !std::filesystem::exists(path, ignored))
    throw Error(ErrorCode::kEnvironment, path + ": not found, expected it next to multum-decode; install multum again");
  void* const module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const found = module != nullptr ? ::dlsym(module, kGetDecoderModule) : nullptr;
  if (found == nullptr) {
    std::fprintf(stderr, "%s\n", ::dlerror());
    std::exit(kNotLoaded);
  }
  return reinterpret_cast<GetDecoderModule>(found)();
}

class Decoder {
 public:
  std::string answer(std::string_view request, SharedMemory& memory) {
    MessageReader in(request);
    const DecodingRequest kind{in.number<std::uint8_t>()};
    if (kind == DecodingRequest::kOpenImage || (kind == DecodingRequest::kReadImage && images_.is_open())) {
      std::string answer = images_.answer(request, memory);
      if (images_.is_open()) return answer;
    }
    if (kind == DecodingRequest::kClose) images_.close();
    if (kind == DecodingRequest::kClose && module_ == nullptr)
      return MessageWriter().number(DecodingAnswer::kDone).take();
    return module().answer(request, memory);
  }

 private:
  DecoderModule& module() {
    if (module_ == nullptr) module_ = load_module();
    return *module_;
  }

  ImageDecoder images_{open_small_library_image};
  DecoderModule* module_ = nullptr;
};

int run(int, char**) {
  MULTUM_CHECK(replaces_zlib_uncompress());
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
