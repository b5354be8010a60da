// SPDX-License-Identifier: Apache-2.0
// Tests that an unexpected message or failure ends only the worker that caused it. The job is reported as lost, and
// another worker replaces this one. The workers here are shell scripts.
#include "host/farm/service/workers/worker_pool.h"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <new>
#include <stdexcept>
#include <system_error>

namespace multum {
namespace {

using namespace std::chrono_literals;

constexpr char kReady[] = "echo '{\"ready\":true}' >&3; ";

struct Ended {
  std::int64_t job = 0;
  WorkResult result;
};

class WorkerPoolTest : public ::testing::Test {
 protected:
  // Starts workers that report that they are ready, read an order, and then run `script`.
  void open(const std::string& script) {
    WorkerPoolSettings settings;
    settings.command = {"/bin/sh", "-c", std::string(kReady) + "read order <&3; " + script};
    settings.lease = 20s;
    pool_ = std::make_unique<WorkerPool>(
        io_, settings, "test",
        WorkerPool::Events{
            [this] { on_ready_(); }, [](std::int64_t, const JobProgress&) {},
            [this](std::int64_t job, const std::string&, int, const WorkResult& result) { on_ended_(job, result); }});
    pool_->start();
  }
  // Runs the event loop until is_so() is true. If a handler throws, only its own work is lost, as in the daemon.
  bool runs_until(const std::function<bool()>& is_so) {
    const auto until = std::chrono::steady_clock::now() + 30s;
    while (!is_so() && std::chrono::steady_clock::now() < until) {
      try {
        io_.run_for(20ms);
        io_.restart();
      } catch (const std::exception&) {
      }
    }
    return is_so();
  }
  bool give_order(std::int64_t job) {
    if (!runs_until([&] { return !pool_->idle().empty(); })) return false;
    WorkOrder order;
    order.job = job;
    return pool_->order(pool_->idle().front(), order);
  }
  // Expects that the order ends and another worker starts.
  void expect_lost(std::int64_t job, const std::string& why) {
    ASSERT_TRUE(runs_until([&] { return !ended_.empty(); }));
    EXPECT_EQ(ended_.front().job, job);
    EXPECT_EQ(ended_.front().result.exit_code, -1);
    EXPECT_NE(ended_.front().result.message.find(why), std::string::npos) << ended_.front().result.message;
    EXPECT_TRUE(runs_until([&] { return !pool_->idle().empty(); })) << "no other worker replaces it";
  }

  boost::asio::io_context io_{1};
  std::unique_ptr<WorkerPool> pool_;
  std::vector<Ended> ended_;
  std::function<void()> on_ready_ = [] {};
  std::function<void(std::int64_t, const WorkResult&)> on_ended_ = [this](std::int64_t job, const WorkResult& result) {
    ended_.push_back({job, result});
  };
};

TEST_F(WorkerPoolTest, WhoTalksNonsenseIsEnded) {
  for (const char* said : {R"({"progress":5})", R"({"progress":{"stage":7}})", R"({"progress":{"done":"much"}})",
                           R"({"ended":7,"attempt":"first"})", R"({"ended":7,"attempt":0,"exit_code":[]})",
                           R"({"ended":7,"attempt":0,"message":{}})"}) {
    SCOPED_TRACE(said);
    ended_.clear();
    open(std::string("echo '") + said + "' >&3; sleep 60");
    ASSERT_TRUE(give_order(7));
    expect_lost(7, "an invalid message");
    pool_.reset();
    io_.restart();
  }
}

TEST_F(WorkerPoolTest, WantOfMemoryIsOneWorkersEnd) {
  int fails = 2;
  on_ready_ = [&] {
    if (fails-- > 0) throw std::bad_alloc();
  };
  open("sleep 60");
  EXPECT_TRUE(give_order(7)) << "workers' messages are no longer read";
}

TEST_F(WorkerPoolTest, AnEndThatCannotBeNotedIsNotedLater) {
  int fails = 3;
  on_ended_ = [&](std::int64_t job, const WorkResult& result) {
    if (fails-- > 0) throw std::system_error(std::make_error_code(std::errc::too_many_files_open));
    ended_.push_back({job, result});
  };
  open(R"(echo '{"ended":7,"attempt":0,"exit_code":0,"message":"","inputs_changed":false}' >&3; sleep 60)");
  ASSERT_TRUE(give_order(7));
  expect_lost(7, "");
  EXPECT_EQ(ended_.size(), 1u);
}

TEST_F(WorkerPoolTest, WhatCannotBeStartedLeavesNoFiles) {
  const auto open_files = [] { return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}); };
  decltype(open_files()) before = 0;
  for (int i = 0; i < 3; ++i) {
    {
      WorkerPoolSettings settings;
      settings.command = {"/none"};
      settings.workers = 3;
      WorkerPool pool(io_, settings, "test", {[] {}, nullptr, nullptr});
      pool.start();
      io_.run_for(20ms);
      EXPECT_EQ(pool.live_count(), 0);
    }
    io_.restart();
    if (i == 0) before = open_files();  // asio has opened its own files before this round
  }
  EXPECT_EQ(open_files(), before);
}

}  // namespace
}  // namespace multum
