// SPDX-License-Identifier: Apache-2.0
#include "host/service/event_hub.h"

#include <boost/asio/post.hpp>

namespace multum {

EventHub::EventHub() : work_(boost::asio::make_work_guard(io_)), thread_([this] { io_.run(); }) {}

EventHub::~EventHub() {
  io_.stop();
  thread_.join();
}

void EventHub::publish(const std::string& kind, std::int64_t job, const std::string& data) {
  const std::uint64_t number = ++last_;
  boost::asio::post(io_, [this, number, kind, job, data] {
    const ServiceEvent event = {number, job,
                                std::make_shared<const std::string>("id: " + std::to_string(number) +
                                                                    "\nevent: " + kind + "\ndata: " + data + "\n\n")};
    kept_.push_back(event);
    if (kept_.size() > kKept) kept_.pop_front();
    for (const auto& [key, listener] : listeners_) listener(event);
  });
}

std::uint64_t EventHub::add(std::uint64_t after, Listener listener) {
  for (const ServiceEvent& event : kept_)
    if (event.number > after) listener(event);
  listeners_[++key_] = std::move(listener);
  return key_;
}

}  // namespace multum
