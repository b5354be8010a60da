// SPDX-License-Identifier: Apache-2.0
// What happens, to everybody who listens: job changes and progress, each with a number, the last ones kept for those
// who come back after a broken line.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>

namespace multum {

struct ServiceEvent {
  std::uint64_t number = 0;
  std::string kind;  // "job", "progress"
  std::int64_t job = 0;
  std::string data;  // JSON
};

/// On one thread.
class EventHub {
 public:
  using Listener = std::function<void(const ServiceEvent&)>;

  void publish(const std::string& kind, std::int64_t job, const std::string& data) {
    const ServiceEvent event = {++last_, kind, job, data};
    kept_.push_back(event);
    if (kept_.size() > kKept) kept_.pop_front();
    for (const auto& [key, listener] : listeners_) listener(event);
  }
  /// Those after `number` that are still kept, then those to come, until remove().
  std::uint64_t add(std::uint64_t after, Listener listener) {
    for (const ServiceEvent& event : kept_)
      if (event.number > after) listener(event);
    listeners_[++key_] = std::move(listener);
    return key_;
  }
  void remove(std::uint64_t key) { listeners_.erase(key); }
  std::uint64_t last() const { return last_; }
  std::size_t listener_count() const { return listeners_.size(); }

 private:
  static constexpr std::size_t kKept = 1024;
  std::deque<ServiceEvent> kept_;
  std::map<std::uint64_t, Listener> listeners_;
  std::uint64_t last_ = 0, key_ = 0;
};

}  // namespace multum
