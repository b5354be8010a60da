// SPDX-License-Identifier: Apache-2.0
// Text for the person at a terminal. File names, what is in files and what a service answers may hold control
// characters, by which a terminal moves its cursor, changes its title or types for its user. Programs write all their
// text by these functions: on a terminal such characters are shown as \x9b; into files and pipes bytes go as they are,
// so that names read from them are the files' own.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace multum {

/// Escapes control characters but tab and newline - C0, DEL, and C1, which as UTF-8 is C2 80 to C2 9F - and bytes that
/// are no UTF-8: each byte as \x and two digits.
std::string shown_text(std::string_view text);

/// Writes text as it is; to a terminal, as shown_text().
void write_shown(std::FILE* stream, std::string_view text);
/// Writes what printf() would, in the same way.
[[gnu::format(printf, 2, 3)]] void print_shown(std::FILE* stream, const char* format, ...);

/// Escapes JSON: DEL and C1, which may stand in its texts alone, as \u escapes. To a reader of JSON it is the same.
std::string escaped_json(std::string_view json);

/// Bytes of the UTF-8 character that begins at `begin`, which is in the text (RFC 3629); 0: none begins there.
std::size_t character_length(std::string_view text, std::size_t begin);

/// Is all of it UTF-8?
bool is_utf8(std::string_view text);
/// Does it hold a control character: C0 with tab and newline, DEL, C1? Bytes that are not UTF-8 are none.
bool holds_control(std::string_view text);

/// Bytes of `text` but for a UTF-8 character at its end that is not whole yet.
std::size_t whole_characters(std::string_view text);

}  // namespace multum
