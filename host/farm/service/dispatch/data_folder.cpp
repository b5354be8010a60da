// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/dispatch/data_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>

#include "host/farm/service/dispatch/refusal.h"
#include "host/farm/service/files/result_listing.h"
#include "host/farm/service/files/staging.h"
#include "host/farm/service/log/service_log.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/output_paths.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr auto kCountedFor = std::chrono::seconds(5);  // jobs write results without notifying the daemon

std::int64_t bytes_below(const std::string& folder) {
  std::int64_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code gone;
    if (entry->is_regular_file(gone) && !entry->is_symlink(gone)) {
      const std::uintmax_t size = entry->file_size(gone);
      if (!gone) bytes += static_cast<std::int64_t>(size);
    }
  }
  return bytes;
}

std::chrono::hours age_of(const fs::directory_entry& entry) {
  std::error_code gone;
  const fs::file_time_type time = entry.last_write_time(gone);
  if (gone) return std::chrono::hours(0);
  return std::chrono::duration_cast<std::chrono::hours>(fs::file_time_type::clock::now() - time);
}

}  // namespace

std::int64_t bytes_on_disk(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  if (fs::is_directory(status)) return bytes_below(path);
  const std::uintmax_t bytes = fs::is_regular_file(status) ? fs::file_size(path, error) : 0;
  return error ? 0 : static_cast<std::int64_t>(bytes);
}

DataFolder::DataFolder(std::string path, std::int64_t bytes_max)
    : path_(std::move(path)),
      bytes_max_(bytes_max),
      own_([this] {
        for (const char* folder : {"/logs", "/uploads", "/results", "/scratch"}) make_folder(path_ + folder);
        return PathRoots({uploads(), results()});
      }()),
      seal_(take_up_seal(path_ + "/seal")) {}

std::int64_t DataFolder::bytes() {
  {
    const std::lock_guard lock(mutex_);
    if (counted_ != Clock::time_point() && Clock::now() - counted_ <= kCountedFor) return bytes_;
  }
  // Small requests do not wait until the files in the folder have been counted.
  std::int64_t counted = 0;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(path_, error))
    if (entry.is_directory(error)) counted += bytes_below(entry.path().string());
  const std::lock_guard lock(mutex_);
  bytes_ = counted;
  counted_ = Clock::now();
  return bytes_;
}

bool DataFolder::is_full() const {
  const std::lock_guard lock(mutex_);
  return bytes_max_ > 0 && bytes_ >= bytes_max_;
}

void DataFolder::count_result(const std::string& output) {
  if (!own_.is_inside(output)) return;
  const std::int64_t bytes = bytes_on_disk(output);
  const std::lock_guard lock(mutex_);
  bytes_ += bytes;
}

// Removes the path relative to the descriptor of its folder, so that symbolic links above the folder have no effect.
void DataFolder::remove_own(const std::string& path, const char* why) {
  const std::int64_t bytes = bytes_on_disk(path);
  try {
    const OpenFile folder = own_.open_folder_of(path);
    const std::string name = fs::path(path).filename().string();
    std::error_code error;
    if (fs::remove_all(fmt::format("/proc/self/fd/{}/{}", folder.descriptor(), name), error) == 0 || error) return;
    service_log(LogSeverity::kInfo, 0, fmt::format("removed {}: {}", path, why));
    const std::lock_guard lock(mutex_);
    bytes_ -= bytes;
  } catch (const Error&) {  // already removed, or behind a link
  }
}

void DataFolder::check_room(std::int64_t more) {
  if (bytes_max_ <= 0) return;
  const std::int64_t there = bytes();
  if (there + more > bytes_max_)
    throw Refusal{507, "quota",
                  fmt::format("uploads, results, logs and pictures take {} of {} bytes, so there is no room for {} "
                              "more; purge jobs, or raise data_max",
                              there, bytes_max_, more)};
}

void DataFolder::take_room(std::int64_t bytes) {
  check_room(bytes);
  const std::lock_guard lock(mutex_);
  bytes_ += bytes;
}

void DataFolder::give_back(std::int64_t bytes) {
  const std::lock_guard lock(mutex_);
  bytes_ -= bytes;
}

std::shared_ptr<UploadFile> DataFolder::begin_upload(std::int64_t bytes_max) {
  std::int64_t coming = 0;
  {
    const std::lock_guard lock(mutex_);
    coming = bytes_coming_ += bytes_max;
  }
  const auto give_back = [this, bytes_max] {
    const std::lock_guard lock(mutex_);
    bytes_coming_ -= bytes_max;
  };
  try {
    check_room(coming);
    return {new UploadFile(uploads()), [give_back](const UploadFile* file) {
              delete file;
              give_back();
            }};
  } catch (...) {
    give_back();
    throw;
  }
}

DataFolder::Upload DataFolder::store(const std::string& name, UploadFile& file) {
  Upload upload;
  upload.sha256 = file.sha256();
  const std::string folder = uploads() + "/" + upload.sha256.substr(0, 32);
  const std::string path = folder + "/" + name;
  std::error_code error;
  const std::lock_guard storing(storing_);
  make_folder(folder);
  const bool is_new = !fs::exists(fs::symlink_status(path, error));
  try {
    file.name(path);
  } catch (...) {
    ::rmdir(folder.c_str());  // fails if it holds another file
    throw;
  }
  if (is_new) {
    const std::lock_guard lock(mutex_);
    bytes_ += file.bytes();
  }
  fs::last_write_time(path, fs::file_time_type::clock::now(), error);
  upload.path = fs::canonical(path).string();
  return upload;
}

// Removes a few files at a time, because the ledger's thread has other work.
struct DataFolder::Sweep {
  static constexpr int kAtOnce = 200;
  std::chrono::hours upload_age;
  std::function<void()> done;
  std::int64_t last_job = 0;
  std::string last_upload;
  bool are_there_more = true;
  // The state at the last commit.
  std::vector<FileNotes::LeftOver> left_overs;
  std::vector<std::string> uploads;
  FileNotes::Uses uses;
};

void DataFolder::sweep(QueueThread& ledger, std::chrono::hours upload_age, std::function<void()> done) {
  const auto sweep = std::make_shared<Sweep>();
  sweep->upload_age = upload_age;
  sweep->done = std::move(done);
  sweep_some(ledger, sweep);
}

// A purge must be on disk before any of its files is removed. Therefore the files are found in one commit and removed
// after this commit.
void DataFolder::sweep_some(QueueThread& ledger, const std::shared_ptr<Sweep>& sweep) {
  const auto end = [sweep] {
    if (sweep->done) sweep->done();
  };
  ledger.run([sweep](JobQueue& queue) { look(queue, *sweep); },
             [=, this, &ledger](const std::exception_ptr& error) {
               if (error) return end();  // left to the next sweep
               ledger.run([=, this](JobQueue& queue) { remove_found(queue, *sweep); },
                          [=, this, &ledger](const std::exception_ptr& failed) {
                            if (failed || !sweep->are_there_more) return end();
                            if (!sweep->left_overs.empty()) sweep->last_job = sweep->left_overs.back().job;
                            if (!sweep->uploads.empty()) sweep->last_upload = sweep->uploads.back();
                            sweep_some(ledger, sweep);
                          });
             });
}

void DataFolder::look(JobQueue& queue, Sweep& sweep) {
  sweep.left_overs = queue.files().left_overs(sweep.last_job, Sweep::kAtOnce);
  sweep.uploads = queue.files().uploads(sweep.last_upload, Sweep::kAtOnce);
  sweep.are_there_more = sweep.left_overs.size() == Sweep::kAtOnce || sweep.uploads.size() == Sweep::kAtOnce;
  if (!sweep.left_overs.empty() || !sweep.uploads.empty()) sweep.uses = queue.files().uses();
}

void DataFolder::remove_found(JobQueue& queue, const Sweep& sweep) {
  if (sweep.left_overs.empty() && sweep.uploads.empty()) return;
  queue.check_kept();
  const FileNotes::Uses uses = queue.files().uses();
  const auto is_used = [&](const std::string& path) { return sweep.uses.have(path) || uses.have(path); };
  std::error_code error;
  for (const auto& [job, output, identity] : sweep.left_overs) {
    if (fs::remove(fmt::format("{}/logs/{}.log", path_, job), error))
      service_log(LogSeverity::kInfo, job, "the log of the purged job was removed");
    if (!output.empty() && is_used(output)) continue;
    // Files that replaced the result, or that changed within it, have an unknown owner and therefore are not removed.
    try {
      const bool is_ours = !identity.empty() && result_identity(own_, output) == identity;
      const bool is_folder = fs::is_directory(fs::symlink_status(output, error));
      if (is_ours && (!is_folder || unlisted_in(output, seal_).empty()))
        remove_own(output, "the result of a purged job");
    } catch (const Error&) {
      continue;  // the file cannot be examined at present
    }
    queue.files().forget_left_over(job);
  }
  for (const std::string& path : sweep.uploads) {
    const std::lock_guard lock(storing_);
    const fs::directory_entry file(path, error);
    const bool is_there = file.exists(error);
    if (is_there && (is_used(path) || age_of(file) < sweep.upload_age)) continue;
    if (is_there) remove_own(path, "an upload that no job needs");
    const std::string folder = fs::path(path).parent_path().string();
    if (own_.is_inside(folder)) ::rmdir(folder.c_str());  // fails if it holds another result
    queue.files().forget_upload(path);
  }
  const std::lock_guard lock(mutex_);
  counted_ = {};
}

}  // namespace multum
