// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/workers/driver_probe.h"

#include <fmt/format.h>

#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/child_process.h"

namespace multum {
namespace {

namespace asio = boost::asio;
using asio::use_awaitable;

constexpr auto kProbeTimeMax = std::chrono::seconds(20);
constexpr std::chrono::seconds kGoodFor = std::chrono::minutes(10), kBadFor = std::chrono::seconds(30);

std::string last_line_said(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  return text.substr(text.rfind('\n') + 1);
}

}  // namespace

DriverProbe::DriverProbe(asio::io_context& io, std::vector<std::string> command)
    : io_(io), command_(std::move(command)) {}

DriverProbe::~DriverProbe() {
  is_ending_ = true;
  pool_.join();
}

DriverProbe::Finding DriverProbe::ask_child() const {
  try {
    ChildLimits limits{kProbeTimeMax};
    limits.is_cancelled = [this] { return is_ending_.load(); };
    const ChildResult result = run_child(command_, limits);
    if (result.is_over_time)
      return {false, fmt::format("the OpenCL drivers did not answer within {} s", kProbeTimeMax.count())};
    if (result.signal != 0) return {false, fmt::format("an OpenCL driver crashed with signal {}", result.signal)};
    return {result.exit_code == 0, result.exit_code == 0 ? "" : last_line_said(result.output)};
  } catch (const std::exception& error) {
    return {false, error.what()};
  }
}

asio::awaitable<DriverProbe::Finding> DriverProbe::look() {
  if (found_ && (is_under_way_ || Clock::now() < good_until_)) co_return *found_;
  const bool is_first = !found_;
  const auto initiate = [&](auto handler) {
    const auto shared = std::make_shared<decltype(handler)>(std::move(handler));
    is_under_way_ = true;
    asio::post(pool_, [this, shared, is_first] {
      const auto finding = std::make_shared<Finding>(ask_child());
      asio::post(io_, [this, shared, is_first, finding] {
        found_ = *finding;
        good_until_ = Clock::now() + (finding->has_device ? Clock::duration(kGoodFor) : Clock::duration(kBadFor));
        is_under_way_ = false;
        if (is_first) (*shared)();
      });
    });
    if (!is_first) asio::post(io_, [shared] { (*shared)(); });
  };
  co_await asio::async_initiate<const asio::use_awaitable_t<>, void()>(initiate, use_awaitable);
  co_return *found_;
}

}  // namespace multum
