// SPDX-License-Identifier: Apache-2.0
// Sets a locale with a decimal comma, as a program that loads libmultum may do.
#pragma once

#include <clocale>
#include <cstdlib>
#include <string>

namespace multum::testing {

/// Sets LC_NUMERIC to German for its lifetime. If the system has no such locale, compiles one by localedef.
class CommaLocale {
 public:
  explicit CommaLocale(const std::string& folder) {
    for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8"})
      if (std::setlocale(LC_NUMERIC, name) != nullptr) return;
    const std::string made = folder + "/de_DE.UTF-8";
    if (std::system(("localedef -i de_DE -f UTF-8 --no-archive '" + made + "' > /dev/null 2>&1").c_str()) != 0) return;
    ::setenv("LOCPATH", folder.c_str(), 1);
    std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
    ::unsetenv("LOCPATH");
  }
  ~CommaLocale() { std::setlocale(LC_NUMERIC, "C"); }
  CommaLocale(const CommaLocale&) = delete;
  CommaLocale& operator=(const CommaLocale&) = delete;

  /// Returns whether the decimal mark is a comma now.
  bool is_set() const { return std::strtod("0,5", nullptr) == 0.5; }
};

}  // namespace multum::testing
