// SPDX-License-Identifier: Apache-2.0
// Accepts UTF-8 as defined in RFC 3629, section 4: no overlong forms, no surrogates, and nothing beyond U+10FFFF. A
// terminal that accepts other forms could find a control character where this decoder finds none.
#include "host/foundation/base/shown_text.h"

#include <unistd.h>

#include <algorithm>
#include <cstdarg>
#include <cstdint>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/messages/stream_turn.h"

namespace multum {
namespace {

constexpr char kHexDigits[] = "0123456789abcdef";

std::uint32_t byte_at(std::string_view text, std::size_t i) { return static_cast<unsigned char>(text[i]); }

// Returns the length of a character, given its first byte. Returns 0 if the byte is not a first byte.
std::size_t announced_length(std::uint32_t first) {
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first <= 0xdf) return 2;
  if (first >= 0xe0 && first <= 0xef) return 3;
  return first >= 0xf0 && first <= 0xf4 ? 4 : 0;
}

bool is_control(std::string_view character) {
  const std::uint32_t first = byte_at(character, 0);
  if (first == 0xc2) return byte_at(character, 1) < 0xa0;
  return first < 0x20 || first == 0x7f;
}

bool is_shown(std::string_view character) { return !is_control(character) || character == "\t" || character == "\n"; }

}  // namespace

std::size_t character_length(std::string_view text, std::size_t begin) {
  const std::uint32_t first = byte_at(text, begin);
  const std::size_t length = announced_length(first);
  if (length == 0 || length > text.size() - begin) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte_at(text, begin + i) & 0xc0) != 0x80) return 0;
  if (length < 3) return length;
  const std::uint32_t second = byte_at(text, begin + 1);
  const bool is_over_long = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
  const bool is_surrogate = first == 0xed && second > 0x9f;
  const bool is_beyond = first == 0xf4 && second > 0x8f;
  return is_over_long || is_surrogate || is_beyond ? 0 : length;
}

std::string shown_text(std::string_view text) {
  std::string shown;
  shown.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = character_length(text, at);
    const std::string_view character = text.substr(at, std::max<std::size_t>(length, 1));
    at += character.size();
    if (length > 0 && is_shown(character)) {
      shown += character;
      continue;
    }
    for (std::size_t i = 0; i < character.size(); ++i) {
      shown += "\\x";
      shown += kHexDigits[byte_at(character, i) >> 4];
      shown += kHexDigits[byte_at(character, i) & 15];
    }
  }
  return shown;
}

void write_shown(std::FILE* stream, std::string_view text) {
  const std::string shown = isatty(fileno(stream)) != 0 ? shown_text(text) : "";
  if (!shown.empty()) text = shown;
  const StreamTurn turn;
  std::fwrite(text.data(), 1, text.size(), stream);  // the stream remembers a failure until it is flushed
}

void print_shown(std::FILE* stream, const char* format, ...) {
  std::va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  const int size = std::vsnprintf(nullptr, 0, format, arguments);
  va_end(arguments);
  std::vector<char> text(static_cast<std::size_t>(std::max(size, 0)) + 1);
  if (size >= 0) std::vsnprintf(text.data(), text.size(), format, again);
  va_end(again);
  write_shown(stream, {text.data(), text.size() - 1});
}

std::string escaped_json(std::string_view json) {
  std::string escaped;
  escaped.reserve(json.size());
  for (std::size_t at = 0; at < json.size(); ++at) {
    const bool is_c1 = json[at] == '\xc2' && at + 1 < json.size() && byte_at(json, at + 1) < 0xa0;
    if (!is_c1 && json[at] != 0x7f) {
      escaped += json[at];
      continue;
    }
    if (is_c1) ++at;  // in UTF-8, U+0080 to U+009F are C2 80 to C2 9F
    escaped += "\\u00";
    escaped += kHexDigits[byte_at(json, at) >> 4];
    escaped += kHexDigits[byte_at(json, at) & 15];
  }
  return escaped;
}

bool is_utf8(std::string_view text) {
  for (std::size_t at = 0, length = 0; at < text.size(); at += length)
    if (length = character_length(text, at); length == 0) return false;
  return true;
}

bool holds_control(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = character_length(text, at);
    if (length > 0 && is_control(text.substr(at, length))) return true;
    at += std::max<std::size_t>(length, 1);
  }
  return false;
}

std::size_t whole_characters(std::string_view text) {
  for (std::size_t left = 1; left <= std::min<std::size_t>(3, text.size()); ++left) {
    const std::uint32_t byte = byte_at(text, text.size() - left);
    if ((byte & 0xc0) == 0x80) continue;
    return announced_length(byte) > left ? text.size() - left : text.size();
  }
  return text.size();
}

}  // namespace multum
