// SPDX-License-Identifier: Apache-2.0
// What happens, to everybody who listens: job changes and progress, each with a number, the last ones kept for those
// who come back after a broken line.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>

namespace multum {

struct ServiceEvent {
  std::uint64_t number = 0;
  std::int64_t job = 0;
  std::shared_ptr<const std::string> text;  // as it goes over the line, one for all who listen
};

/// On one thread.
class EventHub {
 public:
  using Listener = std::function<void(const ServiceEvent&)>;

  /// `kind`: "job" or "progress"; `data`: JSON in one line.
  void publish(const std::string& kind, std::int64_t job, const std::string& data) {
    ++last_;
    const ServiceEvent event = {last_, job,
                                std::make_shared<const std::string>("id: " + std::to_string(last_) +
                                                                    "\nevent: " + kind + "\ndata: " + data + "\n\n")};
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
