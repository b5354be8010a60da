// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/decoding_option.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string_view>

#include "host/image/image_file.h"
#include "host/mesh/mesh_source.h"

namespace multum {
namespace {

// It must be of the same build: nothing is looked for in PATH.
std::string decoder_beside_this_program() {
  std::error_code error;
  return (std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "multum-decode").string();
}

void decode_by(const DecodingChild& child) {
  set_image_opener(open_in_child(child));
  set_mesh_child(child);
}

void decode_here() {
  set_image_opener(open_in_this_process);
  set_mesh_child(std::nullopt);
}

// "child:SECONDS" as seconds; 0: it is none.
int seconds_of(const std::string& place) {
  constexpr std::string_view kStart = "child:";
  constexpr int kSecondsMax = 86400;
  int seconds = 0;
  if (!place.starts_with(kStart)) return 0;
  const auto [end, error] = std::from_chars(place.data() + kStart.size(), place.data() + place.size(), seconds);
  return error == std::errc() && *end == '\0' && seconds <= kSecondsMax ? std::max(seconds, 0) : 0;
}

}  // namespace

void decode_in_child() { decode_by({decoder_beside_this_program()}); }

void add_decoding_option(CLI::App& app, std::string* as_given) {
  decode_in_child();
  app.add_option_function<std::string>(
         "--decode",
         [as_given](const std::string& place) {
           if (as_given != nullptr) *as_given = place;
           if (place == "here") return decode_here();
           DecodingChild child = {decoder_beside_this_program()};
           if (const int seconds = seconds_of(place); seconds > 0) child.time_base_ms = 1000 * seconds;
           decode_by(child);
         },
         "where images and meshes are decoded: in a child process, which a broken file may end and which has 30 s for "
         "a file, and more for a large one (child:SECONDS: so many), or here, if you trust them")
      ->check(CLI::Validator(
          [](std::string& place) {
            return place == "child" || place == "here" || seconds_of(place) > 0
                       ? ""
                       : "'" + place + "': expected child, child:SECONDS (1 to 86400) or here";
          },
          "child|child:SECONDS|here"))
      ->default_str("child");
}

}  // namespace multum
