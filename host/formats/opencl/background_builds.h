// SPDX-License-Identifier: Apache-2.0
// Builds programs in threads of their own while their user does something else. Private to host/formats/opencl.
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
  /// A program's binary, built in the thread's context: none at first, and what a build leaves there the next one
  /// finds.
  using Build = std::function<std::string(cl::Context& context)>;

  BackgroundBuilds() = default;
  /// Waits for the builds that run; those that wait are dropped.
  ~BackgroundBuilds();
  BackgroundBuilds(const BackgroundBuilds&) = delete;
  BackgroundBuilds& operator=(const BackgroundBuilds&) = delete;

  bool has(const std::string& key) const { return results_.count(key) != 0; }
  /// Begins it as soon as a processor is free: as many run at once as the machine has.
  void add(const std::string& key, Build build);
  /// Waits for what was added as `key` and forgets it; none where nothing was. Throws what the build threw.
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
