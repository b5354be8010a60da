// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include <fmt/format.h>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr char kStandardInput[] = "/dev/stdin";
constexpr int kWithoutWaiting = O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;

const char* name_of_kind(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a FIFO";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

[[noreturn]] void refuse_kind(const std::string& path, mode_t mode) {
  refuse_file(path, fmt::format("is {}, expected a regular file", name_of_kind(mode)));
}

// Reports files that open() itself rejects (a socket, a device without a driver), and failures that concern the
// process.
void check_unopened(const std::string& path) {
  const int failure = errno;
  if (failure == EMFILE || failure == ENFILE || failure == ENOMEM || failure == ENAMETOOLONG)
    fail_by_errno(path, "cannot be opened");
  struct stat found {};
  if ((failure == ENXIO || failure == ENODEV) && ::stat(path.c_str(), &found) == 0 && !S_ISREG(found.st_mode))
    refuse_kind(path, found.st_mode);
  errno = failure;
}

struct Opened {
  OpenFile file;
  mode_t mode = 0;
};

Opened open_anything(const std::string& path) {
  Opened opened{OpenFile(::open(path.c_str(), kWithoutWaiting))};
  struct stat found {};
  if (!opened.file.is_open()) return opened;
  if (::fstat(opened.file.descriptor(), &found) != 0) fail_by_errno(path, "cannot be examined");
  opened.mode = found.st_mode;
  // Reads of regular files never wait, so the descriptor gets the usual flags of open() again.
  if (S_ISREG(found.st_mode)) ::fcntl(opened.file.descriptor(), F_SETFL, 0);
  return opened;
}

bool is_below(const fs::path& folder, const fs::path& file) {
  const auto [end, ignored] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return end == folder.end();
}

}  // namespace

OpenFile open_regular_file(const std::string& path, StandardInput input) {
  Opened opened = open_anything(path);
  if (opened.file.is_open() && S_ISREG(opened.mode)) return std::move(opened.file);
  // Standard input is not opened again by its name. Doing so would wait if it is a FIFO, and fail if it is a socket.
  if (input == StandardInput::kAllowed && path == kStandardInput)
    return OpenFile(::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0));
  if (opened.file.is_open()) refuse_kind(path, opened.mode);
  check_unopened(path);
  return OpenFile();
}

OpenFile open_file_beneath(const std::string& folder, const std::string& path) {
  OpenFile file = open_regular_file(path);
  if (!file.is_open()) return file;
  std::error_code error;
  const fs::path above = fs::canonical(folder.empty() ? "." : folder, error);
  if (error) refuse_file(folder, "its name cannot be resolved: " + error.message());
  // Uses the name of the open file, because the path can now name another file.
  const fs::path real = fs::read_symlink(fmt::format("/proc/self/fd/{}", file.descriptor()), error);
  if (error) fail_by_errno("/proc/self/fd", "cannot be read");
  if (!is_below(above, real))
    refuse_file(
        path,
        fmt::format("is a link to {}, which is not in the model's folder; expected a file in or below that folder",
                    real.string()));
  return file;
}

std::string first_bytes(const std::string& path, std::size_t count) {
  const Opened opened = open_anything(path);
  if (!opened.file.is_open()) check_unopened(path);
  if (!opened.file.is_open() || S_ISDIR(opened.mode)) return "";
  if (!S_ISREG(opened.mode)) refuse_kind(path, opened.mode);
  std::string bytes(count, '\0');
  std::size_t done = 0;
  while (done < count) {
    const ssize_t got = ::read(opened.file.descriptor(), bytes.data() + done, count - done);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  bytes.resize(done);
  return bytes;
}

RegularFileStream::RegularFileStream(const std::string& path, StandardInput input)
    : RegularFileStream(open_regular_file(path, input)) {}

RegularFileStream::RegularFileStream(OpenFile file) : std::istream(nullptr) {
  rdbuf(&buffer_);
  if (file.is_open()) buffer_ = __gnu_cxx::stdio_filebuf<char>(file.release(), std::ios::in | std::ios::binary);
  else setstate(std::ios::failbit);  // keeps errno
}

}  // namespace multum
