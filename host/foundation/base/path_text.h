// SPDX-License-Identifier: Apache-2.0
// Stores paths in JSON. A file name can hold any byte except '/' and NUL, but a JSON string holds only characters. A
// byte that is not part of a UTF-8 character is therefore written as one character of the private use area:
//
//   byte 80 .. FF   <->   U+EF80 .. U+EFFF        e.g. "caf\xe9.png" is "caf\uefe9.png"
//
// If a name contains a character of this range, each byte of that character is escaped too, so that no two names have
// the same text. All other names stay unchanged. In Python, this expression gives the name:
// os.fsencode(re.sub("[\uef80-\uefff]", lambda m: chr(ord(m[0]) - 0x1300), text))
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace multum {

/// Returns the valid UTF-8 text that stands for a path.
std::string text_of_path(std::string_view path);
std::vector<std::string> texts_of_paths(const std::vector<std::string>& paths);

/// The inverse of text_of_path(). A text without characters from U+EF80 to U+EFFF is returned unchanged.
std::string path_of_text(std::string_view text);
std::vector<std::string> paths_of_texts(const std::vector<std::string>& texts);

/// Returns a valid UTF-8 text for a message that quotes paths. text_of_path() may already have converted some of the
/// paths. Valid UTF-8 stays unchanged.
std::string text_of_message(std::string_view message);

/// Returns whether text_of_path() leaves the path unchanged, which is never true for a path that is not UTF-8.
bool is_own_text(std::string_view path);

}  // namespace multum
