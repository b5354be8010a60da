// SPDX-License-Identifier: Apache-2.0
#include "host/service/data_folder.h"

#include <fmt/format.h>

#include <boost/asio/post.hpp>
#include <charconv>
#include <filesystem>
#include <memory>

#include "host/base/atomic_file.h"
#include "host/base/content_hash.h"
#include "host/base/error.h"
#include "host/base/output_paths.h"
#include "host/service/http_reply.h"
#include "host/service/service_log.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr auto kCountedFor = std::chrono::seconds(10);  // jobs write results without telling

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

void remove(const fs::path& path, const char* why) {
  std::error_code error;
  fs::remove_all(path, error);
  if (!error) service_log(LogSeverity::kInfo, 0, fmt::format("removed {}: {}", path.string(), why));
}

}  // namespace

DataFolder::DataFolder(std::string path, std::int64_t bytes_max) : path_(std::move(path)), bytes_max_(bytes_max) {
  for (const char* folder : {"/logs", "/uploads", "/results", "/scratch"}) make_folder(path_ + folder);
}

DataFolder::~DataFolder() { pool_.join(); }

std::int64_t DataFolder::bytes() {
  const std::lock_guard lock(mutex_);
  if (counted_ == Clock::time_point() || Clock::now() - counted_ > kCountedFor) {
    bytes_ = 0;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(path_, error))
      if (entry.is_directory(error)) bytes_ += bytes_below(entry.path().string());
    counted_ = Clock::now();
  }
  return bytes_;
}

void DataFolder::check_room(std::int64_t more) {
  if (bytes_max_ <= 0) return;
  const std::int64_t there = bytes();
  if (there + more > bytes_max_)
    throw Refusal{
        507, "quota",
        fmt::format("uploads, results, logs and pictures take {} bytes, and may take {}: {} more are too many; purge "
                    "jobs, or ask for more by data_max",
                    there, bytes_max_, more)};
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
  make_folder(folder);
  if (!fs::exists(path, error)) {
    const std::lock_guard lock(mutex_);
    bytes_ += file.bytes();
  }
  file.name(path);
  fs::last_write_time(path, fs::file_time_type::clock::now(), error);
  upload.path = fs::canonical(path).string();
  return upload;
}

void DataFolder::sweep(QueueThread& ledger, std::chrono::hours upload_age) {
  const auto uses = std::make_shared<JobQueue::Uses>();
  const std::string uploads_folder = fs::weakly_canonical(uploads()).string(),
                    results_folder = fs::weakly_canonical(results()).string();
  ledger.run([=](JobQueue& queue) { *uses = queue.uses(uploads_folder + "/", results_folder + "/"); },
             [=, this](const std::exception_ptr& error) {
               if (error) return;  // the next sweep
               boost::asio::post(pool_, [=, this] {
                 std::error_code ignored;
                 for (const fs::directory_entry& folder : fs::directory_iterator(uploads_folder, ignored)) {
                   bool is_used = false, is_young = age_of(folder) < upload_age;
                   for (const fs::directory_entry& file : fs::directory_iterator(folder, ignored)) {
                     is_used = is_used || uses->inputs.contains(file.path().string());
                     is_young = is_young || age_of(file) < upload_age;
                   }
                   if (!is_used && !is_young) remove(folder.path(), "an upload that no job waits for any more");
                 }
                 for (const fs::directory_entry& result : fs::directory_iterator(results_folder, ignored)) {
                   const std::string name = result.path().filename().string();
                   if (name.starts_with(".multum-")) continue;  // of running jobs; swept at a start
                   // A job's result may have been renamed into place a moment ago.
                   if (!uses->outputs.contains(result.path().string()) && age_of(result) >= std::chrono::hours(1))
                     remove(result.path(), "the result of a job that was purged");
                 }
                 for (const fs::directory_entry& log : fs::directory_iterator(path_ + "/logs", ignored)) {
                   std::int64_t id = 0;
                   const std::string name = log.path().stem().string();
                   std::from_chars(name.data(), name.data() + name.size(), id);
                   if (id <= uses->last_id && !uses->ids.contains(id) && age_of(log) >= std::chrono::hours(1))
                     remove(log.path(), "the log of a job that was purged");
                 }
                 const std::lock_guard lock(mutex_);
                 counted_ = {};
               });
             });
}

}  // namespace multum
