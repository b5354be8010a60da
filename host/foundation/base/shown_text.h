// SPDX-License-Identifier: Apache-2.0
// Shows text to the user of a terminal. File names, file contents and answers of a service may hold control characters.
// Such characters can make a terminal move its cursor, change its title or type for its user. Programs write all text
// with these functions. On terminals, control characters appear as \x9b, for example. Files and pipes get the bytes
// unchanged, so that other programs can read names from them.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace multum {

/// Escapes control characters (C0, DEL, and C1, which in UTF-8 is C2 80 to C2 9F), except for tab and newline. Bytes
/// that are not UTF-8 are escaped too. Each escaped byte becomes \x and two digits.
std::string shown_text(std::string_view text);

/// If the stream is a terminal, writes shown_text() of the text. Otherwise writes the text unchanged.
void write_shown(std::FILE* stream, std::string_view text);
/// Formats its arguments like printf() and writes the result in the same way.
[[gnu::format(printf, 2, 3)]] void print_shown(std::FILE* stream, const char* format, ...);

/// Writes DEL and C1 characters in valid JSON as \u escapes. In valid JSON, only strings can hold these characters.
/// JSON parsers read the same value.
std::string escaped_json(std::string_view json);

/// Returns the length of the UTF-8 character (RFC 3629) that begins at `begin`, a position within the text. Returns 0
/// if no character begins there.
std::size_t character_length(std::string_view text, std::size_t begin);

/// Returns whether the whole text is UTF-8.
bool is_utf8(std::string_view text);
/// Returns whether the text holds a control character: C0 (including tab and newline), DEL, or C1. Ignores bytes that
/// are not UTF-8.
bool holds_control(std::string_view text);

/// Returns the length of `text` without an incomplete UTF-8 character at its end.
std::size_t whole_characters(std::string_view text);

}  // namespace multum
