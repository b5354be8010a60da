// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/path_text.h"

#include <algorithm>

#include "host/foundation/base/shown_text.h"

namespace multum {
namespace {

// In UTF-8, the characters U+EF80 to U+EFBF are EE BE 80 to EE BE BF, and U+EFC0 to U+EFFF are EE BF 80 to EE BF BF.
constexpr std::size_t kEscapeBytes = 3;

bool is_escape(std::string_view character) {
  return character.size() == kEscapeBytes && (character.starts_with("\xee\xbe") || character.starts_with("\xee\xbf"));
}

void append_escape(std::string& text, char byte) {
  const auto bits = static_cast<unsigned char>(byte);
  text += '\xee';
  text += bits < 0xc0 ? '\xbe' : '\xbf';
  text += static_cast<char>(0x80 | (bits & 0x3f));
}

char escaped_byte(std::string_view escape) {
  const auto low = static_cast<unsigned char>(escape[2]) & 0x3f;
  return static_cast<char>((escape[1] == '\xbe' ? 0x80 : 0xc0) | low);
}

// Returns the character at `at`. If no valid character begins there, returns one byte, with `is_character` false.
std::string_view next_piece(std::string_view text, std::size_t at, bool& is_character) {
  const std::size_t length = character_length(text, at);
  is_character = length > 0;
  return text.substr(at, std::max<std::size_t>(length, 1));
}

// Escapes all bytes, except for the characters for which `stays` returns true.
template <typename Stays>
std::string escaped(std::string_view bytes, const Stays& stays) {
  std::string text;
  text.reserve(bytes.size());
  bool is_character = false;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::string_view piece = next_piece(bytes, at, is_character);
    at += piece.size();
    if (is_character && stays(piece)) {
      text += piece;
      continue;
    }
    for (const char byte : piece) append_escape(text, byte);
  }
  return text;
}

}  // namespace

std::string text_of_path(std::string_view path) {
  return escaped(path, [](std::string_view character) { return !is_escape(character); });
}

std::string text_of_message(std::string_view message) {
  return escaped(message, [](std::string_view) { return true; });
}

std::string path_of_text(std::string_view text) {
  std::string path;
  path.reserve(text.size());
  bool is_character = false;
  for (std::size_t at = 0; at < text.size();) {
    const std::string_view piece = next_piece(text, at, is_character);
    at += piece.size();
    if (is_escape(piece)) path += escaped_byte(piece);
    else path += piece;
  }
  return path;
}

std::vector<std::string> texts_of_paths(const std::vector<std::string>& paths) {
  std::vector<std::string> texts;
  for (const std::string& path : paths) texts.push_back(text_of_path(path));
  return texts;
}

std::vector<std::string> paths_of_texts(const std::vector<std::string>& texts) {
  std::vector<std::string> paths;
  for (const std::string& text : texts) paths.push_back(path_of_text(text));
  return paths;
}

bool is_own_text(std::string_view path) { return text_of_path(path) == path; }

}  // namespace multum
