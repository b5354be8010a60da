// SPDX-License-Identifier: Apache-2.0
// Manages the folder DATA, where the daemon keeps files for others: uploads by content, results for those who have no
// other place, logs. Held to a limit, and swept: what the ledger names as finished with goes, and nothing else.
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

/// Bytes of a file, or of all files below a folder; of a link and what is not there none. Blocks.
std::int64_t bytes_on_disk(const std::string& path);

class DataFolder {
 public:
  /// `bytes_max`: of all of it together, but for the ledger; 0: any.
  DataFolder(std::string path, std::int64_t bytes_max);
  DataFolder(const DataFolder&) = delete;
  DataFolder& operator=(const DataFolder&) = delete;

  std::string uploads() const { return path_ + "/uploads"; }
  std::string results() const { return path_ + "/results"; }
  /// Of folders that this daemon publishes, here and elsewhere.
  const ResultSeal& seal() const { return seal_; }

  /// Blocks. Room for an upload of at most so many bytes; what is not stored of it is free again when it is gone.
  /// Throws as check_room() does, and Error(kEnvironment) as files do. The folder outlives it.
  std::shared_ptr<UploadFile> begin_upload(std::int64_t bytes_max);
  struct Upload {
    std::string path, sha256;
  };
  /// Blocks. The same content under the same name is one file, and as young as its last upload. Throws
  /// Error(kEnvironment) as files do.
  Upload store(const std::string& name, UploadFile& file);
  /// Blocks. Throws Refusal 507 "quota" when so many bytes more are too many.
  void check_room(std::int64_t bytes);
  /// Blocks. Counts what others have made in the folder; throws as check_room() does, and then does not count it.
  void take_room(std::int64_t bytes);
  /// What take_room() counted is gone.
  void give_back(std::int64_t bytes);
  const std::string& path() const { return path_; }

  /// Is the folder at its limit, by the last count? Looks at no disk.
  bool is_full() const;
  /// A result has come: counts it, when it lies here.
  void count_result(const std::string& output);

  /// On the ledger's thread, where results are published too: removes the results and logs of purged jobs that no other
  /// job has a use for, and uploads that are older than `upload_age` and that no unfinished job names. What no ledger
  /// has noted stays.
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
  const PathRoots own_;  // uploads and results
  const ResultSeal seal_;
  mutable std::mutex mutex_;
  std::int64_t bytes_ = 0, bytes_coming_ = 0;
  std::chrono::steady_clock::time_point counted_;  // no moment: never
  std::mutex storing_;                             // a folder may not go between its making and its file's
};

}  // namespace multum
