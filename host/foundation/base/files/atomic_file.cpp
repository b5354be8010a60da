// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/output_file.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

// ".multum-tmp-PID-RANDOM-PLACE-NAME" is a hidden file of process PID on the machine or container PLACE. Files of
// earlier versions have a counter instead of the random digits. These files are also removed if their processes were
// killed.
constexpr char kPrefix[] = ".multum-tmp-";
constexpr std::size_t kPlaceDigits = 8;
constexpr std::time_t kForeignSeconds = 24 * 60 * 60;

// Identifies the machine or the container, because process numbers are valid only there, and several machines can write
// to one folder.
const std::string& place() {
  static const std::string digits = [] {
    char host[256] = {};
    gethostname(host, sizeof(host) - 1);
    std::error_code ignored;
    return hash_text(host + fs::read_symlink("/proc/self/ns/pid", ignored).string()).substr(0, kPlaceDigits);
  }();
  return digits;
}

// Returns whether the temporary file `found` of `name` was left by a process that has ended. Processes of other places
// cannot be checked, so a file of another place counts as left over after one day.
bool is_leftover(const std::string& found, const std::string& name, const struct stat& state) {
  const std::size_t number = found.find('-', sizeof(kPrefix) - 1);
  const std::size_t rest = number == std::string::npos ? number : found.find('-', number + 1);
  if (rest == std::string::npos) return false;
  const std::string owner = found.substr(rest + 1);
  if (owner == name || owner == place() + "-" + name) {
    const long pid = std::strtol(found.c_str() + sizeof(kPrefix) - 1, nullptr, 10);
    return pid > 0 && kill(static_cast<pid_t>(pid), 0) != 0 && errno == ESRCH;
  }
  return owner.size() == kPlaceDigits + 1 + name.size() && owner.ends_with("-" + name) &&
         std::time(nullptr) - state.st_mtim.tv_sec > kForeignSeconds;
}

// Removes only files of this user, because other users' files can have such names too. The directory is listed once per
// written file. Files of running processes are never touched.
void sweep_leftovers(const NamedPlace& place, const std::string& path) {
  std::vector<std::string> names;
  try {
    names = names_in(place.folder, path);
  } catch (const Error&) {  // the folder cannot be listed
  }
  for (const std::string& found : names) {
    struct stat state {};
    if (is_temporary_name(found) &&
        ::fstatat(place.folder.descriptor(), found.c_str(), &state, AT_SYMLINK_NOFOLLOW) == 0 &&
        S_ISREG(state.st_mode) && state.st_uid == ::geteuid() && is_leftover(found, place.name, state))
      ::unlinkat(place.folder.descriptor(), found.c_str(), 0);
  }
}

// Rejects the name of an existing object that is not a regular file. Otherwise that object would be lost, or the
// program would write to it by accident.
void check_final_name(const NamedPlace& place, const std::string& path) {
  const auto refuse = [&](const char* what) {
    throw Error(ErrorCode::kUsage, path + ": " + what + ", expected the name of a file to write");
  };
  if (place.name.empty() || place.name == "." || place.name == "..") refuse("is a folder");
  check_name_length(path, place.name);
  struct stat found {};
  if (::fstatat(place.folder.descriptor(), place.name.c_str(), &found, 0) != 0) return;
  if (S_ISDIR(found.st_mode)) refuse("is a folder");
  if (!S_ISREG(found.st_mode)) refuse("is a device, a pipe or a socket");
}

}  // namespace

bool is_temporary_name(std::string_view name) { return name.starts_with(kPrefix); }

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)), place_(open_place(path_)) {
  check_final_name(place_, path_);
  sweep_leftovers(place_, path_);
  temporary_name_ = fmt::format("{}{}-{}-{}-{}", kPrefix, ::getpid(), random_digits(), place(), place_.name);
  file_ = OpenFile(::openat(place_.folder.descriptor(), temporary_name_.c_str(),
                            O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666));
  if (!file_.is_open()) fail_by_errno(path_, "cannot create a file in its folder");
  open_path_ = fmt::format("/proc/{}/fd/{}", ::getpid(), file_.descriptor());
}

AtomicFile::~AtomicFile() {
  if (!committed_ && is_named(place_.folder, temporary_name_, file_.descriptor()))
    ::unlinkat(place_.folder.descriptor(), temporary_name_.c_str(), 0);
}

void AtomicFile::commit() {
  MULTUM_CHECK(!committed_);
  const int folder = place_.folder.descriptor();
  if (::fsync(file_.descriptor()) != 0) fail_by_errno(path_, "cannot be synced to disk");
  if (!is_named(place_.folder, temporary_name_, file_.descriptor()))
    throw Error(ErrorCode::kEnvironment,
                path_ +
                    ": its temporary file was removed or replaced during writing; expected a folder where no other "
                    "program renames files");
  if (::renameat(folder, temporary_name_.c_str(), folder, place_.name.c_str()) != 0)
    fail_by_errno(path_, "cannot be renamed to its final name");
  committed_ = true;
  // A folder that cannot be listed cannot be opened for syncing either.
  const OpenFile synced(::openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (synced.is_open() && ::fsync(synced.descriptor()) != 0)
    fail_by_errno(path_, "its folder cannot be synced to disk");
}

void write_text_file(const std::string& path, std::string_view text) {
  AtomicFile file(path);
  OutputFile out(file);
  write_or_throw(out, text.data(), text.size());
  out.close();
  file.commit();
}

}  // namespace multum
