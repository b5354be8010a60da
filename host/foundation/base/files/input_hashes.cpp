// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/input_hashes.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/open_file.h"

namespace multum {
namespace {

// File times have the resolution of the kernel's timer tick, 1 to 10 ms on Linux, so two writes within one tick have
// the same time. If a file was written very recently, it is therefore examined after a short delay, so that any later
// write gets another time. File systems that store whole seconds (FAT) are not supported.
constexpr std::int64_t kTickNs = 20'000'000;

std::int64_t nanoseconds(const timespec& time) { return time.tv_sec * std::int64_t{1'000'000'000} + time.tv_nsec; }

std::int64_t now_ns() {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
}

}  // namespace

std::optional<InputHashes::Stamp> InputHashes::stamp_of(const std::string& path) {
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0) return std::nullopt;
  return Stamp{found.st_dev, found.st_ino, found.st_size, nanoseconds(found.st_mtim), nanoseconds(found.st_ctim)};
}

InputHashes::Known* InputHashes::noted(const std::string& path) {
  if (const auto found = known_.find(path); found != known_.end()) return &found->second;
  std::optional<Stamp> stamp = stamp_of(path);
  if (!stamp) return nullptr;
  // If a clock that runs ahead caused a file time in the future, the wait is not longer.
  const std::int64_t age = std::max(std::int64_t{0}, now_ns() - stamp->changed_ns);
  if (age < kTickNs) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(kTickNs - age));
    stamp = stamp_of(path);
    if (!stamp) return nullptr;
  }
  return &known_.emplace(path, Known{*stamp, std::nullopt}).first->second;
}

void InputHashes::check(const Known& known, const std::string& path) {
  if (stamp_of(path) != known.stamp)
    throw Error(ErrorCode::kInput,
                path + ": changed while it was being read, expected a file that no program is writing");
}

void InputHashes::note(const std::string& path) {
  const std::lock_guard lock(mutex_);
  noted(path);
}

std::string InputHashes::hash(const std::string& path) {
  const std::lock_guard lock(mutex_);
  Known* const known = noted(path);
  if (known == nullptr) return hash_file(path);  // throws with the reason
  if (known->hash) return *known->hash;
  const std::string hash = hash_file(path);
  ++read_count_;
  check(*known, path);
  known->hash = hash;
  return hash;
}

void InputHashes::check_unchanged(const std::string& path) {
  const std::lock_guard lock(mutex_);
  if (const auto found = known_.find(path); found != known_.end()) check(found->second, path);
}

InputHashes::FileState InputHashes::state(const std::string& path) {
  const std::lock_guard lock(mutex_);
  const Known* const known = noted(path);
  return known == nullptr ? FileState{} : FileState{known->stamp.size, known->stamp.modified_ns};
}

void InputHashes::take(const std::string& path, const FileState& state, const std::string& hash) {
  const std::lock_guard lock(mutex_);
  Known* const known = noted(path);
  if (known == nullptr || known->hash || state != FileState{known->stamp.size, known->stamp.modified_ns}) return;
  known->hash = hash;
}

int InputHashes::read_count() const {
  const std::lock_guard lock(mutex_);
  return read_count_;
}

std::optional<std::string> hash_regular_file(const std::string& path) {
  const OpenFile file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  struct stat found {};
  if (!file.is_open() || ::fstat(file.descriptor(), &found) != 0 || !S_ISREG(found.st_mode)) return std::nullopt;
  return hash_file("/proc/self/fd/" + std::to_string(file.descriptor()));
}

}  // namespace multum
