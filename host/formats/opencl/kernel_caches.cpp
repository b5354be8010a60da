// SPDX-License-Identifier: Apache-2.0
#include "host/formats/opencl/kernel_caches.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <mutex>
#include <system_error>
#include <utility>

#include "host/formats/opencl/program_cache.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/process_rules/process_rules.h"
#include "host/foundation/base/system_failure.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

// A folder that is removed by the process that made it, but not by a child that fork() made.
class PrivateFolder {
 public:
  explicit PrivateFolder(const std::string& above) : path_(above + "/multum-cache-XXXXXX"), owner_(::getpid()) {
    if (::mkdtemp(path_.data()) == nullptr) fail_by_errno(above, "cannot make a private folder for compiled kernels");
  }
  ~PrivateFolder() {
    std::error_code ignored;
    if (::getpid() == owner_) fs::remove_all(path_, ignored);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  const pid_t owner_;
};

// Returns why no folder can be made inside `folder`, or an empty text if one can be made. Tries to make a folder,
// because permissions do not show this (root, a read-only or full disk).
std::string why_not_writable(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return errno_text(error.value());
  std::string probe = folder + "/.multum-probe-XXXXXX";
  if (::mkdtemp(probe.data()) == nullptr) return errno_text(errno);
  ::rmdir(probe.c_str());
  return "";
}

class KernelCaches {
 public:
  void set(const KernelCacheFolders& folders) {
    const std::lock_guard lock(mutex_);
    folders_ = folders;
    is_prepared_ = false;
    set_program_cache_folder(folders.programs);
  }

  void prepare() {
    const std::lock_guard lock(mutex_);
    if (std::exchange(is_prepared_, true)) return;
    pocl_failure_.clear();
    replace(folders_.programs, "MULTUM_CACHE_DIR", "programs");
    set_program_cache_folder(folders_.programs);
    pocl_failure_ = replace(folders_.pocl, "POCL_CACHE_DIR", "pocl");
  }

  const std::string& pocl_failure() const { return pocl_failure_; }

 private:
  // Replaces a folder that cannot be written by a private one. Returns the reason if that fails. Otherwise returns an
  // empty string.
  std::string replace(std::string& folder, const char* variable, const char* name) {
    if (folder.empty()) return "";
    const std::string why = why_not_writable(folder);
    if (why.empty()) return "";
    const std::string place = folder;
    std::string said = "cannot store compiled kernels here: " + why;
    try {
      if (private_ == nullptr) private_ = std::make_unique<PrivateFolder>(fs::temp_directory_path().string());
      folder = private_->path() + "/" + name;
      fs::create_directory(folder);
      if (!prefer_environment(variable, folder, true) && &folder == &folders_.pocl)
        return fmt::format("{}: {}. Set {} to a writable folder", place, said, variable);
      log_warning(place, fmt::format("{}, so they are compiled again into a private folder, which is deleted when this "
                                     "program ends. Set {} to a writable folder",
                                     said, variable));
      return "";
    } catch (const std::exception& error) {  // the driver may work without a cache
      said += std::string("; ") + error.what();
      log_warning(place, said);
    }
    return place + ": " + said;
  }

  std::mutex mutex_;
  KernelCacheFolders folders_;
  bool is_prepared_ = true;  // until set() names folders
  std::string pocl_failure_;
  std::unique_ptr<PrivateFolder> private_;
};

KernelCaches& kernel_caches() {
  static KernelCaches caches;
  return caches;
}

}  // namespace

KernelCacheFolders kernel_cache_folders(const char* (*variable)(const char* name)) {
  const auto is_set = [](const char* value) { return value != nullptr && *value != '\0'; };
  std::string cache;  // of the user; empty if the user has none
  if (const char* xdg = variable("XDG_CACHE_HOME"); is_set(xdg)) cache = xdg;
  else if (const char* home = variable("HOME"); is_set(home)) cache = std::string(home) + "/.cache";
  const char* programs = variable("MULTUM_CACHE_DIR");
  const char* pocl = variable("POCL_CACHE_DIR");
  return {programs != nullptr ? programs
          : cache.empty()     ? ""
                              : cache + "/multum",
          pocl != nullptr ? pocl : (cache.empty() ? "/tmp" : cache) + "/pocl/kcache"};
}

void set_kernel_caches(const KernelCacheFolders& folders) { kernel_caches().set(folders); }
void prepare_kernel_caches() { kernel_caches().prepare(); }
const std::string& pocl_cache_failure() { return kernel_caches().pocl_failure(); }

}  // namespace multum
