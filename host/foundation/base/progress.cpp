// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/progress.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>

#include "host/foundation/base/error.h"
#include "host/foundation/base/messages/stream_turn.h"
#include "host/foundation/base/processes/interrupt.h"
#include "host/foundation/base/shown_text.h"

namespace multum {

void Progress::start(std::uint64_t units_total) {
  event_.units_total = units_total;
  event_.units_done = 0;
  report();
}

void Progress::stage(const std::string& name) {
  event_.stage = name;
  report();
}

void Progress::advance(std::uint64_t units) {
  event_.units_done += units;
  report();
}

void Progress::finish() {
  event_.units_done = event_.units_total;
  if (callback_) callback_(event_);
}

void Progress::report() {
  if (callback_ && !callback_(event_)) throw Cancelled();
}

namespace {

// The signal handler writes these variables and any thread reads them, so only lock-free atomics are allowed.
std::atomic<int> g_interrupted{0};
std::atomic<int> g_interrupted_at{0};  // time of the signal, in seconds of a steady clock
static_assert(std::atomic<int>::is_always_lock_free);

int steady_seconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<int>(now.tv_sec);
}

// The first signal asks the program to stop. A later signal ends a program that does not react, but only after a delay.
// The delay is needed because some senders (timeout of coreutils, agents of farms) signal a process and then its group.
// On an overloaded machine, seconds can pass between these two signals. The delay is shorter for a user who presses
// Ctrl-C again.
void on_interrupt(int signal) {
  if (g_interrupted == 0) {
    g_interrupted_at = steady_seconds();
    g_interrupted = 1;
  } else if (steady_seconds() - g_interrupted_at > (signal == SIGINT ? 1 : 10)) {
    std::signal(signal, SIG_DFL);
    raise(signal);
  }
}

}  // namespace

bool is_interrupted() { return g_interrupted != 0; }

namespace {

// The OpenCL driver loads LLVM, which replaces these handlers with its own. The first signal removes LLVM's handlers
// again (SA_RESETHAND), so a second signal at the same moment would end the program. Therefore this program restores
// its handlers regularly.
void keep_interrupt_handlers() {
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction action = {};
    if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler == on_interrupt) continue;
    action = {};
    action.sa_handler = on_interrupt;
    sigaction(signal, &action, nullptr);
  }
}

class TerminalBar {
 public:
  ~TerminalBar() { clear(); }

  void show(const ProgressEvent& event) {
    const auto now = std::chrono::steady_clock::now();
    if (event.units_done == 0) start_ = now;
    const bool finished = event.units_total > 0 && event.units_done >= event.units_total;
    if (!finished && shown_ && now - last_ < std::chrono::milliseconds(80)) return;
    last_ = now;
    shown_ = true;
    constexpr int kCells = 30;
    const double fraction =
        event.units_total == 0
            ? 0.0
            : std::min(1.0, static_cast<double>(event.units_done) / static_cast<double>(event.units_total));
    const int filled = static_cast<int>(fraction * kCells);
    const std::string bar =
        std::string(static_cast<size_t>(filled), '#') + std::string(static_cast<size_t>(kCells - filled), '.');
    if (finished) return clear();
    show_bar(
        fmt::format("[{}] {:3.0f}%  {}{}", bar, fraction * 100.0, shown_text(event.stage), time_left(fraction, now)));
  }

 private:
  void clear() {
    if (shown_) {
      const StreamTurn wipes_it;
    }
    shown_ = false;
  }
  // Estimates the remaining time from the average speed so far. Returns nothing for short work and at the beginning.
  std::string time_left(double fraction, std::chrono::steady_clock::time_point now) const {
    const double spent = std::chrono::duration<double>(now - start_).count();
    if (spent < 5.0 || fraction < 0.02 || fraction >= 1.0) return "";
    const long seconds = std::lround(spent * (1.0 - fraction) / fraction);
    return seconds >= 60 ? fmt::format(", {} min {:02} s left", seconds / 60, seconds % 60)
                         : fmt::format(", {} s left", seconds);
  }

  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_;
  bool shown_ = false;
};

}  // namespace

std::unique_ptr<Progress> make_terminal_progress(bool show_bar) {
  keep_interrupt_handlers();
  auto bar = show_bar && isatty(STDERR_FILENO) != 0 ? std::make_shared<TerminalBar>() : nullptr;
  return std::make_unique<Progress>([bar](const ProgressEvent& event) {
    keep_interrupt_handlers();
    if (bar) bar->show(event);
    return g_interrupted == 0;
  });
}

}  // namespace multum
