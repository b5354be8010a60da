// SPDX-License-Identifier: Apache-2.0
#include "host/service/files/result_copy.h"

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>

#include "host/base/error.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

void sync(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool is_synced = file >= 0 && ::fsync(file) == 0;
  if (file >= 0) ::close(file);
  if (!is_synced) throw Error(ErrorCode::kEnvironment, path.string() + ": cannot be synced");
}

}  // namespace

void copy_result(const std::string& from, const std::string& to) {
  std::error_code error;
  fs::remove_all(to, error);
  fs::copy(from, to, fs::copy_options::recursive | fs::copy_options::copy_symlinks, error);
  if (error) throw Error(ErrorCode::kEnvironment, from + ": cannot be copied to " + to + ": " + error.message());
  if (fs::is_directory(to))
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(to)) sync(entry.path());
  sync(to);
}

}  // namespace multum
