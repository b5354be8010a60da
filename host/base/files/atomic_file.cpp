// SPDX-License-Identifier: Apache-2.0
#include "host/base/files/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "host/base/error.h"
#include "host/base/files/content_hash.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

// ".multum-tmp-PID-COUNTER-PLACE-NAME": hidden, owned by a process of a place, and with the final name's extension.
constexpr char kPrefix[] = ".multum-tmp-";
constexpr std::size_t kPlaceDigits = 8;
constexpr auto kForeignAge = std::chrono::hours(24);

// Of the machine, or of the container: numbers of processes say something there alone, and many write to one folder.
const std::string& place() {
  static const std::string digits = [] {
    char host[256] = {};
    gethostname(host, sizeof(host) - 1);
    std::error_code ignored;
    return hash_text(host + fs::read_symlink("/proc/self/ns/pid", ignored).string()).substr(0, kPlaceDigits);
  }();
  return digits;
}

// Whether a temporary file of `name` was left by a process that is gone. Of other places nobody knows: a day is enough.
bool is_leftover(const fs::directory_entry& entry, const std::string& name) {
  const std::string found = entry.path().filename().string();
  if (!is_temporary_name(found)) return false;
  const std::size_t number = found.find('-', sizeof(kPrefix) - 1);
  const std::size_t rest = number == std::string::npos ? number : found.find('-', number + 1);
  if (rest == std::string::npos) return false;
  const std::string owner = found.substr(rest + 1);
  if (owner == name || owner == place() + "-" + name) {
    const long pid = std::strtol(found.c_str() + sizeof(kPrefix) - 1, nullptr, 10);
    return pid > 0 && kill(static_cast<pid_t>(pid), 0) != 0 && errno == ESRCH;
  }
  std::error_code failed;
  const auto written = entry.last_write_time(failed);
  return owner.size() == kPlaceDigits + 1 + name.size() && owner.ends_with("-" + name) && !failed &&
         fs::file_time_type::clock::now() - written > kForeignAge;
}

// The sweep costs one directory listing a file written and never touches a living process's file.
void sweep_leftovers(const fs::path& folder, const std::string& name) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (is_leftover(entry, name)) fs::remove(entry.path(), ignored);
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
  const std::string owner = std::to_string(getpid()) + "-" + std::to_string(counter++) + "-" + place();
  temporary_path_ = (folder / (kPrefix + owner + "-" + name)).string();
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
