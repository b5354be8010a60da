// SPDX-License-Identifier: Apache-2.0
// Makes a folder that is removed when the test ends. Checks that an error message contains the expected parts.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/foundation/base/error.h"

namespace multum::testing {

using Names = std::set<std::string>;

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "multum_test_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) ADD_FAILURE() << "no temporary folder";
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  /// Returns the names of everything in the folder, including hidden files.
  Names names() const {
    Names found;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) found.insert(entry.path().filename().string());
    return found;
  }

 private:
  std::string path_;
};

inline std::string read_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  EXPECT_TRUE(in) << path;
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary);
  out << bytes;
  EXPECT_TRUE(out.flush()) << path;
}

/// Returns whether `text` contains `part`. A number at an end of `part` must be a whole number: "2" is neither in "12"
/// nor in "2.5" nor in a folder's random name.
inline bool says(const std::string& text, const std::string& part) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto is_word = [&](char c) { return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto at = [&](std::size_t i) { return i < text.size() ? text[i] : ' '; };  // also before the first line
  for (std::size_t i = text.find(part); i != std::string::npos; i = text.find(part, i + 1)) {
    const std::size_t end = i + part.size();
    if (part.empty()) return true;
    if (is_digit(part.front()) && (is_word(at(i - 1)) || (at(i - 1) == '.' && is_digit(at(i - 2))))) continue;
    if (is_digit(part.back()) && (is_word(at(end)) || (at(end) == '.' && is_digit(at(end + 1))))) continue;
    return true;
  }
  return false;
}

/// Checks that a message contains all of `parts`: the file, the option or key, the value found, the value expected.
/// Parts are not whole sentences, because sentences are rewritten now and then.
inline void expect_says(const std::string& text, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) EXPECT_TRUE(says(text, part)) << "no \"" << part << "\" in: " << text;
}

/// Runs `body`, which must throw Error with `code` and a message that contains all of `parts`.
inline void expect_error(ErrorCode code, const std::vector<std::string>& parts, const std::function<void()>& body) {
  try {
    body();
    ADD_FAILURE() << "no error was thrown, expected one with \"" << (parts.empty() ? "" : parts[0]) << '"';
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    expect_says(error.what(), parts);
  }
}

}  // namespace multum::testing
