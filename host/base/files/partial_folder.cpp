// SPDX-License-Identifier: Apache-2.0
#include "host/base/files/partial_folder.h"

#include <filesystem>
#include <system_error>
#include <utility>

namespace multum {

namespace fs = std::filesystem;

namespace {

std::string folder_of(const std::string& output) {
  const fs::path path(output);
  const fs::path above = path.has_parent_path() ? path.parent_path() : fs::path(".");
  return (above / (".multum-partial-" + path.filename().string())).string();
}

}  // namespace

std::unique_ptr<PartialFolder> PartialFolder::take(const std::string& output) {
  std::string folder = folder_of(output);
  std::unique_ptr<FolderLock> lock = FolderLock::take(folder);
  if (lock == nullptr) return nullptr;
  return std::unique_ptr<PartialFolder>(new PartialFolder(std::move(folder), std::move(lock)));
}

void PartialFolder::drop(const std::string& output) {
  std::error_code ignored;
  if (fs::is_directory(folder_of(output), ignored)) take(output);
}

PartialFolder::~PartialFolder() {
  std::error_code ignored;
  if (!stays_) fs::remove_all(path_, ignored);
}

void PartialFolder::clear() const {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(path_)) fs::remove_all(entry.path(), ignored);
}

}  // namespace multum
