// SPDX-License-Identifier: Apache-2.0
// multum-decode: the child of multum and multum-view that reads image files for them (host/image/child_image_file.cpp).
// It is no command: its requests come over a socket that it is given.
#include <cstdio>

#include "host/base/error.h"
#include "host/base/helper_service.h"
#include "host/image/decoding_messages.h"

namespace multum {
namespace {

int run(int, char**) {
  ImageDecoder decoder;
  const int exit_code =
      serve_helper([&](std::string_view request, SharedMemory& memory) { return decoder.answer(request, memory); });
  if (exit_code != 0)
    std::fputs("multum-decode: multum and multum-view start it, to read images for them; by itself it does nothing\n",
               stderr);
  return exit_code;
}

}  // namespace
}  // namespace multum

int main(int argc, char** argv) { return multum::run_guarded("multum-decode", multum::run, argc, argv); }
