// SPDX-License-Identifier: Apache-2.0
// Paths in JSON. A name of a file may hold any byte but '/' and NUL, and a text of JSON holds characters. A byte that
// is part of no UTF-8 character is written as one character of the private use area, and read back from it:
//
//   byte 80 .. FF   <->   U+EF80 .. U+EFFF        e.g. "caf\xe9.png" is "caf\uefe9.png"
//
// A character of that range in a name is written in the same way, byte by byte, so that no two names are one text.
// Every other name is its own text. In Python, os.fsencode(re.sub("[\uef80-\uefff]", lambda m: chr(ord(m[0]) - 0x1300),
// text)) is the name.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace multum {

/// A text of valid UTF-8 for a path.
std::string text_of_path(std::string_view path);
std::vector<std::string> texts_of_paths(const std::vector<std::string>& paths);

/// The path that text_of_path() wrote so; a text without characters from U+EF80 to U+EFFF is its own path.
std::string path_of_text(std::string_view text);
std::vector<std::string> paths_of_texts(const std::vector<std::string>& texts);

/// A text of valid UTF-8 for a message that quotes paths, some perhaps as texts already: what is UTF-8 stays as it is.
std::string text_of_message(std::string_view message);

/// Does text_of_path() leave it as it is? False for every name that is not UTF-8.
bool is_own_text(std::string_view path);

}  // namespace multum
