// SPDX-License-Identifier: Apache-2.0
// Sends events to everybody who listens: job changes and progress, each with a number, the last ones kept for those who
// come back after a broken line. Listeners are served on a thread of the hub's own: however many there are, those who
// publish and those who ask other things do not wait for them.
#pragma once

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>

namespace multum {

struct ServiceEvent {
  std::uint64_t number = 0;
  std::int64_t job = 0;
  std::shared_ptr<const std::string> text;  // as it goes over the line, one for all who listen
};

class EventHub {
 public:
  using Listener = std::function<void(const ServiceEvent&)>;

  /// Numbers go on after `first`: those of a later daemon must be larger than those of an earlier one.
  explicit EventHub(std::uint64_t first);
  /// Ends its thread, whatever runs there.
  ~EventHub();
  EventHub(const EventHub&) = delete;
  EventHub& operator=(const EventHub&) = delete;

  /// On one thread, always the same. `kind`: "job" or "progress"; `data`: JSON in one line.
  void publish(const std::string& kind, std::int64_t job, const std::string& data);
  /// The number of the last event published.
  std::uint64_t last() const { return last_; }

  /// Bytes of all events whose texts are kept, here or by listeners.
  std::size_t bytes() const { return *bytes_; }

  /// Its thread runs this: what listeners do belongs there, and the calls below too.
  boost::asio::io_context& io() { return io_; }
  /// Hands out the events after number `after` that are still kept (0: all of this hub's), then those to come, until
  /// remove(). Where some in between are no longer kept, or `after` was counted by another daemon, begins with an event
  /// of the kind "missed", of no job.
  std::uint64_t add(std::uint64_t after, Listener listener);
  void remove(std::uint64_t key) { listeners_.erase(key); }

 private:
  static constexpr std::size_t kKept = 1024;
  static constexpr std::size_t kKeptBytes = 16 << 20;
  ServiceEvent event_of(std::uint64_t number, std::int64_t job, const std::string& kind, const std::string& data) const;
  std::shared_ptr<std::atomic<std::size_t>> bytes_ = std::make_shared<std::atomic<std::size_t>>(0);
  boost::asio::io_context io_{1};
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  std::deque<ServiceEvent> kept_;
  std::size_t kept_bytes_ = 0;
  const std::uint64_t first_;
  std::map<std::uint64_t, Listener> listeners_;
  std::atomic<std::uint64_t> last_;
  std::uint64_t key_ = 0;
  std::thread thread_;
};

}  // namespace multum
