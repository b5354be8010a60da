// SPDX-License-Identifier: Apache-2.0
#include "host/base/files/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "host/base/error.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

// ".multum-tmp-PID-COUNTER-NAME": hidden, owned by a process, and with the final name's extension.
constexpr char kPrefix[] = ".multum-tmp-";

// Temporary files for `name` whose process is gone are left-overs of a killed run. The sweep costs one directory
// listing a file written and never touches a living process's file.
void sweep_leftovers(const fs::path& folder, const std::string& name) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string found = entry.path().filename().string();
    if (!is_temporary_name(found) || !found.ends_with("-" + name)) continue;
    const long pid = std::strtol(found.c_str() + sizeof(kPrefix) - 1, nullptr, 10);
    if (pid > 0 && kill(static_cast<pid_t>(pid), 0) != 0 && errno == ESRCH) fs::remove(entry.path(), ignored);
  }
}

void sync_path(const std::string& path, int flags) {
  const int descriptor = open(path.c_str(), flags);
  if (descriptor < 0) fail_by_errno(path, "cannot be opened to sync it");
  const int result = fsync(descriptor);
  const int saved_errno = errno;
  close(descriptor);
  if (result != 0) {
    errno = saved_errno;
    fail_by_errno(path, "cannot be synced to disk");
  }
}

}  // namespace

bool is_temporary_name(std::string_view name) { return name.starts_with(kPrefix); }

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  const fs::path final_path(path_);
  const fs::path folder = folder_of(final_path);
  const std::string name = final_path.filename().string();
  std::error_code error;
  if (name.empty() || fs::is_directory(final_path, error))
    throw Error(ErrorCode::kUsage, path_ + ": is a folder, expected the name of a file to write");
  if (!fs::is_directory(folder, error))
    throw Error(ErrorCode::kEnvironment, path_ + ": the folder " + folder.string() + " does not exist");
  if (access(folder.c_str(), W_OK) != 0) fail_by_errno(path_, "the folder " + folder.string() + " cannot be written");
  sweep_leftovers(folder, name);
  static std::atomic<unsigned> counter{0};
  temporary_path_ =
      (folder / (kPrefix + std::to_string(getpid()) + "-" + std::to_string(counter++) + "-" + name)).string();
}

AtomicFile::~AtomicFile() {
  if (!committed_) unlink(temporary_path_.c_str());
}

void AtomicFile::commit() {
  MULTUM_CHECK(!committed_);
  sync_path(temporary_path_, O_RDONLY);
  if (std::rename(temporary_path_.c_str(), path_.c_str()) != 0) fail_by_errno(path_, "cannot be given its final name");
  committed_ = true;
  sync_path(folder_of(path_).string(), O_RDONLY | O_DIRECTORY);
}

void write_text_file(const std::string& path, std::string_view text) {
  AtomicFile file(path);
  // Exclusively: a link that somebody put there is not followed.
  std::FILE* out = std::fopen(file.temporary_path().c_str(), "wbx");
  if (out == nullptr) fail_by_errno(path, "cannot be written");
  const bool written = std::fwrite(text.data(), 1, text.size(), out) == text.size();
  const bool closed = std::fclose(out) == 0;
  if (!written || !closed) fail_by_errno(path, "writing failed");
  file.commit();
}

}  // namespace multum
