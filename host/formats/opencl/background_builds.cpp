// SPDX-License-Identifier: Apache-2.0
#include "host/formats/opencl/background_builds.h"

#include <utility>

#include "host/foundation/base/processes/machine.h"

namespace multum {

BackgroundBuilds::~BackgroundBuilds() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    waiting_.clear();
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void BackgroundBuilds::add(const std::string& key, Build build) {
  Task task(std::move(build));
  results_[key] = task.get_future();
  const std::lock_guard lock(mutex_);
  waiting_.push_back(std::move(task));
  if (waiting_.size() > idle_ && threads_.size() < static_cast<std::size_t>(processor_count()))
    threads_.emplace_back([this] { work(); });
  changed_.notify_one();
}

std::optional<std::string> BackgroundBuilds::take(const std::string& key) {
  const auto found = results_.find(key);
  if (found == results_.end()) return std::nullopt;
  std::future<std::string> result = std::move(found->second);
  results_.erase(found);
  return result.get();
}

void BackgroundBuilds::work() {
  cl::Context context;
  std::unique_lock lock(mutex_);
  for (;;) {
    ++idle_;
    changed_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
    --idle_;
    if (ending_) return;
    Task task = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    task(context);
    lock.lock();
  }
}

}  // namespace multum
