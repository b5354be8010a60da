// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/measuring/scratch_folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "host/foundation/base/error.h"

namespace multum::bench {
namespace {

void sync_descriptor_of(const std::string& path, int flags) {
  const int descriptor = open(path.c_str(), flags);
  const bool synced = descriptor >= 0 && fsync(descriptor) == 0;
  const int reason = errno;
  if (descriptor >= 0) close(descriptor);
  if (!synced) throw Error(ErrorCode::kEnvironment, path + ": cannot be synced to disk: " + std::strerror(reason));
}

}  // namespace

ScratchFolder::ScratchFolder(const std::string& parent) {
  std::error_code missing;
  const std::filesystem::path folder =
      parent.empty() ? std::filesystem::temp_directory_path(missing) : std::filesystem::absolute(parent);
  std::string pattern = (folder / "multum-bench-XXXXXX").string();
  if (missing || mkdtemp(pattern.data()) == nullptr)
    throw Error(ErrorCode::kEnvironment,
                "cannot make a folder in " + folder.string() + ": " + std::strerror(missing ? missing.value() : errno));
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

void sync_file(const std::string& path) {
  sync_descriptor_of(path, O_RDONLY);
  sync_descriptor_of(std::filesystem::path(path).parent_path().string(), O_RDONLY | O_DIRECTORY);
}

}  // namespace multum::bench
