// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/decoding_option.h"

#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

#include "host/formats/image/files/image_file.h"
#include "host/formats/mesh/mesh_source.h"

namespace multum {
namespace {

constexpr int kSecondsMax = 86400;
constexpr std::uint64_t kMemoryMin = std::uint64_t{128} << 20;  // the libraries of the child process need half of this

std::optional<std::uint64_t> byte_count(std::string text) {
  std::uint64_t bytes = 0;
  try {
    if (!CLI::AsSizeValue(false)(text).empty()) return std::nullopt;
  } catch (const CLI::ValidationError&) {
    return std::nullopt;
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), bytes);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(bytes) : std::nullopt;
}

// Parses "child", "child:SECONDS" and "child:SECONDS,MEMORY". Returns nullopt for any other text.
std::optional<DecodingChild> child_of(std::string_view text) {
  DecodingChild child;
  if (text == "child") return child;
  if (!text.starts_with("child:")) return std::nullopt;
  text.remove_prefix(std::string_view("child:").size());
  const std::string_view seconds_text = text.substr(0, text.find(','));
  int seconds = 0;
  const auto [end, error] = std::from_chars(seconds_text.begin(), seconds_text.end(), seconds);
  if (error != std::errc() || end != seconds_text.end() || seconds < 1 || seconds > kSecondsMax) return std::nullopt;
  child.time_base_ms = 1000 * seconds;
  if (seconds_text.size() == text.size()) return child;
  const std::optional<std::uint64_t> memory = byte_count(std::string(text.substr(seconds_text.size() + 1)));
  if (!memory || *memory < kMemoryMin) return std::nullopt;
  child.memory_base = *memory;
  return child;
}

}  // namespace

void add_decoding_option(CLI::App& app, std::string* as_given) {
  app.add_option_function<std::string>(
         "--decode",
         [as_given](const std::string& text) {
           if (as_given != nullptr) *as_given = text;
           const DecodingChild child = child_of(text).value_or(DecodingChild{});
           set_image_opener(open_in_child(child));
           set_mesh_child(child);
         },
         "limit the time and memory for decoding one image or mesh, such as child:120,4G (default: 30 s and 1 GiB, "
         "more for large files)")
      ->check(CLI::Validator(
          [](std::string& text) {
            return child_of(text)
                       ? ""
                       : "'" + text +
                             "': expected child, child:SECONDS (1 to 86400) or child:SECONDS,MEMORY (128M or more)";
          },
          "child|child:SECONDS[,MEMORY]"))
      ->default_str("child");
}

}  // namespace multum
