// SPDX-License-Identifier: Apache-2.0
// Sends events to all listeners. Events report job changes and progress, and each event has a number. The last events
// are kept for clients that reconnect. The hub serves listeners on a separate thread, so publishers and other requests
// do not wait, however many listeners there are.
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
  std::shared_ptr<const std::string> text;  // the text as sent, shared by all listeners
};

class EventHub {
 public:
  using Listener = std::function<void(const ServiceEvent&)>;

  /// Numbers events from `first` on. A restarted daemon must use larger numbers than before.
  explicit EventHub(std::uint64_t first);
  /// Ends the hub's thread, even if it still has work.
  ~EventHub();
  EventHub(const EventHub&) = delete;
  EventHub& operator=(const EventHub&) = delete;

  /// Always called on the same thread. `kind` is "job" or "progress", and `data` is JSON on one line.
  void publish(const std::string& kind, std::int64_t job, const std::string& data);
  /// The number of the last published event.
  std::uint64_t last() const { return last_; }

  /// The number of bytes of all event texts that the hub or its listeners keep.
  std::size_t bytes() const { return *bytes_; }

  /// The hub's thread runs this io_context. Use listeners, and make the calls below, only on that thread.
  boost::asio::io_context& io() { return io_; }
  /// Sends the kept events after number `after` (or all of them if it is 0), and then new events until remove(). If
  /// some of these events are lost, or if `after` is a number from another daemon, first sends an event of the kind
  /// "missed", which belongs to no job.
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
