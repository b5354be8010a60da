// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/files/file_hashes.h"

#include "host/farm/service/files/staging.h"
#include "host/foundation/base/files/content_hash.h"

namespace multum {
namespace {

constexpr std::size_t kKnownMax = 100000;  // number of files, which take about 30 MB

}  // namespace

std::string FileHashes::hash(const std::string& path, const OpenFile& file) {
  const std::string opened = "/proc/self/fd/" + std::to_string(file.descriptor());
  const std::string identity = file_identity(opened);
  {
    const std::lock_guard lock(mutex_);
    const auto found = known_.find(path);
    if (found != known_.end() && !identity.empty() && found->second.identity == identity) return found->second.hash;
  }
  const std::string hash = hash_file(opened);
  // The hash is remembered only if the file did not change meanwhile.
  if (file_identity(opened) == identity) {
    const std::lock_guard lock(mutex_);
    if (known_.size() >= kKnownMax) known_.clear();
    known_[path] = {identity, hash};
  }
  return hash;
}

}  // namespace multum
