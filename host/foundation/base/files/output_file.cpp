// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/output_file.h"

#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/system_failure.h"

namespace multum {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

[[noreturn]] void fail(const std::string& shown_path, int failure) {
  throw Error(ErrorCode::kEnvironment, shown_path + ": writing failed: " + errno_text(failure));
}

}  // namespace

OutputFile::OutputFile(const AtomicFile& file) : shown_path_(file.path()), file_(nullptr) {
  const int own = ::fcntl(file.descriptor(), F_DUPFD_CLOEXEC, 0);
  if (own >= 0) file_ = ::fdopen(own, "wb");
  if (file_ == nullptr) {
    const int failure = errno;
    if (own >= 0) ::close(own);
    fail(shown_path_, failure);
  }
  std::setvbuf(file_, nullptr, _IOFBF, kBufferBytes);
}

OutputFile::~OutputFile() {
  if (file_ != nullptr) std::fclose(file_);
}

bool OutputFile::keep(bool succeeded) {
  if (!succeeded && failure_ == 0) failure_ = errno != 0 ? errno : EIO;
  return succeeded;
}

bool OutputFile::write(const void* bytes, std::size_t count) {
  if (!keep(std::fwrite(bytes, 1, count, file_) == count)) return false;
  position_ += count;
  return true;
}

bool OutputFile::seek(std::uint64_t position) {
  if (!keep(fseeko(file_, static_cast<off_t>(position), SEEK_SET) == 0)) return false;
  position_ = position;
  return true;
}

std::string OutputFile::failure() const { return failure_ == 0 ? "" : errno_text(failure_); }

void OutputFile::close() {
  keep(std::fclose(std::exchange(file_, nullptr)) == 0);
  if (failure_ != 0) fail(shown_path_, failure_);
}

}  // namespace multum
