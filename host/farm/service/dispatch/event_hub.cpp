// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/dispatch/event_hub.h"

#include <boost/asio/post.hpp>

#include "host/farm/service/log/run_handlers.h"

namespace multum {

ServiceEvent EventHub::event_of(std::uint64_t number, std::int64_t job, const std::string& kind,
                                const std::string& data) const {
  auto text = std::make_unique<const std::string>("id: " + std::to_string(number) + "\nevent: " + kind +
                                                  "\ndata: " + data + "\n\n");
  *bytes_ += text->size();
  return {number, job, std::shared_ptr<const std::string>(text.release(), [all = bytes_](const std::string* gone) {
            *all -= gone->size();
            delete gone;
          })};
}

EventHub::EventHub(std::uint64_t first)
    : work_(boost::asio::make_work_guard(io_)),
      first_(first),
      last_(first),
      thread_([this] { run_handlers(io_, LogSeverity::kWarning, "dropped an event listener"); }) {}

EventHub::~EventHub() {
  io_.stop();
  thread_.join();
}

void EventHub::publish(const std::string& kind, std::int64_t job, const std::string& data) {
  const std::uint64_t number = ++last_;
  boost::asio::post(io_, [this, number, kind, job, data] {
    const ServiceEvent event = event_of(number, job, kind, data);
    kept_.push_back(event);
    kept_bytes_ += event.text->size();
    while (kept_.size() > kKept || (kept_.size() > 1 && kept_bytes_ > kKeptBytes)) {
      kept_bytes_ -= kept_.front().text->size();
      kept_.pop_front();
    }
    for (const auto& [key, listener] : listeners_) listener(event);
  });
}

std::uint64_t EventHub::add(std::uint64_t after, Listener listener) {
  const std::uint64_t before_kept = kept_.empty() ? first_ : kept_.front().number - 1;
  const bool has_missed = after == 0 ? before_kept > first_ : after < before_kept || after > last_;
  if (has_missed) listener(event_of(before_kept, 0, "missed", "{}"));
  for (const ServiceEvent& event : kept_)
    if (has_missed || event.number > after) listener(event);
  listeners_[++key_] = std::move(listener);
  return key_;
}

}  // namespace multum
