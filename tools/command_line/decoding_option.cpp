// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/decoding_option.h"

#include <filesystem>

#include "host/image/image_file.h"

namespace multum {
namespace {

// It must be of the same build: nothing is looked for in PATH.
std::string decoder_beside_this_program() {
  std::error_code error;
  return (std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "multum-decode").string();
}

}  // namespace

void decode_in_child() {
  DecodingChild child;
  child.program = decoder_beside_this_program();
  set_image_opener(open_in_child(child));
}

void add_decoding_option(CLI::App& app) {
  decode_in_child();
  app.add_option_function<std::string>(
         "--decode",
         [](const std::string& place) {
           if (place == "here") set_image_opener(open_in_this_process);
         },
         "where image files are decoded: in a child process, which a broken file may end, or here, if you trust them")
      ->check(CLI::IsMember({"child", "here"}))
      ->default_str("child");
}

}  // namespace multum
