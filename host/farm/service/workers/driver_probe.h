// SPDX-License-Identifier: Apache-2.0
// Finds out, on request, whether this machine has an OpenCL device for jobs. A child process does this, because drivers
// can crash or hang.
#pragma once

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace multum {

class DriverProbe {
 public:
  struct Finding {
    bool has_device = false;
    std::string message;  // the reason if there is no device
  };

  /// `command` ends with exit code 0 if there is a device. Otherwise its last line gives the reason. Answers on the
  /// thread of `io`.
  DriverProbe(boost::asio::io_context& io, std::vector<std::string> command);
  /// Ends the running child.
  ~DriverProbe();
  DriverProbe(const DriverProbe&) = delete;
  DriverProbe& operator=(const DriverProbe&) = delete;

  /// Returns the last result. The first caller waits for it. A result is renewed in the background after ten minutes,
  /// or after half a minute if there was no device.
  boost::asio::awaitable<Finding> look();

 private:
  using Clock = std::chrono::steady_clock;
  Finding ask_child() const;

  boost::asio::io_context& io_;
  const std::vector<std::string> command_;
  std::optional<Finding> found_;
  Clock::time_point good_until_;
  bool is_under_way_ = false;
  std::atomic<bool> is_ending_ = false;
  boost::asio::thread_pool pool_{1};
};

}  // namespace multum
