// SPDX-License-Identifier: Apache-2.0
// Manages the folder DATA, where the daemon stores files for clients. These files are uploads by content, results that
// have no other place, and logs. Limits the size of the folder, and removes only files that the ledger lists as no
// longer needed.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "host/farm/service/files/result_seal.h"
#include "host/farm/service/files/upload_file.h"
#include "host/farm/service/ledger/queue_thread.h"
#include "host/foundation/sandbox/path_roots.h"

namespace multum {

/// Returns the size in bytes of a file, or of all files below a folder. Returns 0 for a symbolic link or a missing
/// path. Blocks.
std::int64_t bytes_on_disk(const std::string& path);

class DataFolder {
 public:
  /// `bytes_max` limits the size of the whole folder except for the ledger. 0 means that there is no limit.
  DataFolder(std::string path, std::int64_t bytes_max);
  DataFolder(const DataFolder&) = delete;
  DataFolder& operator=(const DataFolder&) = delete;

  std::string uploads() const { return path_ + "/uploads"; }
  std::string results() const { return path_ + "/results"; }
  /// The seal of all folders that this daemon publishes, in DATA and elsewhere.
  const ResultSeal& seal() const { return seal_; }

  /// Blocks. Reserves room for an upload of at most `bytes_max`. The destructor of the upload frees the unused part.
  /// Throws like check_room(), and throws Error(kEnvironment) for file errors. The folder must outlive the upload.
  std::shared_ptr<UploadFile> begin_upload(std::int64_t bytes_max);
  struct Upload {
    std::string path, sha256;
  };
  /// Blocks. Stores uploads with the same name and content as one file, whose age counts from the last upload. Throws
  /// Error(kEnvironment) for file errors.
  Upload store(const std::string& name, UploadFile& file);
  /// Blocks. Throws Refusal 507 "quota" when `bytes` more would exceed the limit.
  void check_room(std::int64_t bytes);
  /// Blocks. Counts files that other processes have made in the folder. Throws like check_room(). In this case, the
  /// files are not counted.
  void take_room(std::int64_t bytes);
  /// Subtracts bytes that take_room() counted.
  void give_back(std::int64_t bytes);
  const std::string& path() const { return path_; }

  /// Returns whether the folder was at its limit at the last count. Does not access the disk.
  bool is_full() const;
  /// Counts a new result if it is in this folder.
  void count_result(const std::string& output);

  /// Removes results and logs of purged jobs if no other job uses them. Also removes uploads that are older than
  /// `upload_age` if no unfinished job names them. Does not remove files that are not recorded in a ledger. Runs on the
  /// ledger's thread, which also publishes results.
  void sweep(QueueThread& ledger, std::chrono::hours upload_age, std::function<void()> done = nullptr);

 private:
  std::int64_t bytes();
  void remove_own(const std::string& path, const char* why);
  struct Sweep;
  void sweep_some(QueueThread& ledger, const std::shared_ptr<Sweep>& sweep);
  static void look(JobQueue& queue, Sweep& sweep);
  void remove_found(JobQueue& queue, const Sweep& sweep);
  const std::string path_;
  const std::int64_t bytes_max_;
  const PathRoots own_;  // the folders of uploads and results
  const ResultSeal seal_;
  mutable std::mutex mutex_;
  std::int64_t bytes_ = 0, bytes_coming_ = 0;
  std::chrono::steady_clock::time_point counted_;  // the default value means never
  std::mutex storing_;                             // prevents the removal of a new folder before its file exists
};

}  // namespace multum
