// SPDX-License-Identifier: Apache-2.0
// Implements host/foundation/base/process_rules for libmultum, which changes nothing in the process that loads it.
#if !defined(_WIN32)
#include <dlfcn.h>
#endif

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "host/api/multum.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/process_rules/process_rules.h"

namespace multum {

bool prefer_environment(const char*, const std::string&, bool) { return false; }

void require_environment(const char* name, const std::string& value, const std::string& reason) {
  if (std::getenv(name) != nullptr) return;
  throw Error(ErrorCode::kEnvironment, std::string("environment variable ") + name + " is not set, expected " + name +
                                           "=" + value + " before the process starts: " + reason);
}

void show_log_line(const std::string&) {}

// For a library in PREFIX/lib or PREFIX/lib/ARCHITECTURE, multum-decode is in PREFIX/libexec/multum. In a Python wheel,
// it is next to the library. In a build folder, it is in the folder bin next to the folder of the library.
#if defined(_WIN32)
std::string program_folder() { return ""; }  // the library only reads files, and starts no multum-decode
#else
std::string program_folder() {
  Dl_info found = {};
  if (::dladdr(reinterpret_cast<const void*>(&multum_version), &found) == 0 || found.dli_fname == nullptr) return "";
  std::error_code error;
  const std::filesystem::path library = std::filesystem::canonical(found.dli_fname, error).parent_path();
  for (const char* folder : {".", "../libexec/multum", "../../libexec/multum", "../bin"}) {
    const std::filesystem::path found_folder = (library / folder).lexically_normal();
    if (std::filesystem::exists(found_folder / "multum-decode", error)) return found_folder.string();
  }
  return library.string();
}
#endif

void check_failed(const char* condition, const char* file, int line) {
  throw std::logic_error(std::string("check failed: ") + condition + " (" + file + ":" + std::to_string(line) + ")");
}

}  // namespace multum
