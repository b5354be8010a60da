// SPDX-License-Identifier: Apache-2.0
// Builds programs in separate threads while the user does something else. Private to host/formats/opencl.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host/formats/opencl/cl_headers.h"

namespace multum {

class BackgroundBuilds {
 public:
  /// Returns the binary of a program that was built in the thread's context. The context is null at first. Later builds
  /// in the same thread reuse the context of the first build.
  using Build = std::function<std::string(cl::Context& context)>;

  BackgroundBuilds() = default;
  /// Waits for builds that are running, and drops builds that are waiting.
  ~BackgroundBuilds();
  BackgroundBuilds(const BackgroundBuilds&) = delete;
  BackgroundBuilds& operator=(const BackgroundBuilds&) = delete;

  bool has(const std::string& key) const { return results_.count(key) != 0; }
  /// Queues a build. At most one build per core runs at a time.
  void add(const std::string& key, Build build);
  /// Waits for the build that was added as `key`, and forgets it. Returns nothing if there was no such build. If the
  /// build threw an exception, rethrows it.
  std::optional<std::string> take(const std::string& key);

 private:
  using Task = std::packaged_task<std::string(cl::Context&)>;

  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> waiting_;
  std::map<std::string, std::future<std::string>> results_;
  std::vector<std::thread> threads_;
  std::size_t idle_ = 0;
  bool ending_ = false;
};

}  // namespace multum
