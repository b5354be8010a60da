// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/map_turns.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/messages/log_listener.h"
#include "host/foundation/base/shown_text.h"
#include "tools/multum/openjd_lines.h"

namespace multum {
namespace {

// A stream that collects text.
class TextStream {
 public:
  TextStream() : stream_(::open_memstream(&text_, &size_)) {
    if (stream_ == nullptr) throw std::bad_alloc();
  }
  ~TextStream() {
    std::fclose(stream_);
    std::free(text_);
  }
  TextStream(const TextStream&) = delete;
  TextStream& operator=(const TextStream&) = delete;

  std::FILE* stream() const { return stream_; }
  std::string text() const {
    std::fflush(stream_);
    return {text_, size_};
  }

 private:
  char* text_ = nullptr;
  std::size_t size_ = 0;
  std::FILE* stream_;
};

// The output and the log of one map.
class HeldOutput : public LogListener {
 public:
  void hear(LogKind kind, const std::string& line) override {
    const std::lock_guard lock(mutex_);
    lines_.emplace_back(kind, line);
  }
  std::FILE* out() const { return out_.stream(); }
  std::FILE* err() const { return err_.stream(); }

  void show() const {
    for (const auto& [kind, line] : lines_) switch (kind) {
        case LogKind::kWarning: log_named_warning(line); break;
        case LogKind::kInfo: log_info(line); break;
        case LogKind::kVerbose: log_verbose(line); break;
      }
    write_shown(stderr, err_.text());
    write_shown(stdout, out_.text());
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<LogKind, std::string>> lines_;
  const TextStream out_, err_;
};

// The progress of all maps together. Every map counts the same.
class SharedProgress {
 public:
  SharedProgress(std::size_t count, const CommonOptions& common)
      : count_(count), whole_(make_progress(common)), units_(count) {
    whole_->start(kUnits * count);
    whole_->stage(fmt::format("map 1 of {}", count_));
  }

  // Returns the progress of one map. It cancels the map if the user or another map asks for it.
  Progress of_map(std::size_t map) {
    return Progress([this, map](const ProgressEvent& event) {
      const double done =
          event.units_total == 0
              ? 0.0
              : std::min(1.0, static_cast<double>(event.units_done) / static_cast<double>(event.units_total));
      return advance_to(map, done);
    });
  }
  void finish_map(std::size_t map) {
    {
      const std::lock_guard lock(mutex_);
      ++finished_;
    }
    advance_to(map, 1.0);
  }
  // Call this function after all threads have ended. Throws Cancelled if a map was not finished.
  void finish() {
    if (finished_ < count_) throw Cancelled();
    whole_->finish();
  }
  void cancel() { is_cancelled_ = true; }
  bool is_cancelled() const { return is_cancelled_; }

 private:
  static constexpr std::uint64_t kUnits = 1000;  // for each map

  // Returns false if the work is cancelled.
  bool advance_to(std::size_t map, double done) {
    const std::lock_guard lock(mutex_);
    const auto units = static_cast<std::uint64_t>(std::lround(done * static_cast<double>(kUnits)));
    const std::uint64_t more = units > units_[map] ? units - units_[map] : 0;
    units_[map] += more;
    try {
      if (shown_ != finished_ && finished_ < count_)
        whole_->stage(fmt::format("map {} of {}", (shown_ = finished_) + 1, count_));
      // The last units are left to finish(), because a bar that is full is removed.
      whole_->advance(finished_ < count_ ? more : 0);
    } catch (const Cancelled&) {
      is_cancelled_ = true;
    }
    return !is_cancelled_;
  }

  const std::size_t count_;
  std::mutex mutex_;
  const std::unique_ptr<Progress> whole_;
  std::vector<std::uint64_t> units_;  // [map]
  std::size_t finished_ = 0, shown_ = 0;
  std::atomic<bool> is_cancelled_{false};
};

// Works on several maps at the same time.
class SeveralTurns {
 public:
  SeveralTurns(const MapTurns& turns, const CommonOptions& common, Device& device,
               const std::function<void(const MapTurn&)>& work)
      : turns_(turns), device_(device), work_(work), progress_(turns.count, common), held_(turns.count) {}

  void run() {
    if (take_first_turn()) {
      std::vector<std::jthread> others;
      for (int i = 1; i < turns_.at_once; ++i)
        others.emplace_back([this] {
          guard([this] {
            Device device = Device::when_needed(turns_.device);
            work_off(device);
          });
        });
      work_off(device_);
    }
    for (const auto& held : held_)  // maps that were finished after a map that was not
      if (held) held->show();
    if (failure_) std::rethrow_exception(failure_);
    progress_.finish();
  }

 private:
  // The first map needs no other output to be shown before it, so its output is not held. Users see at once that
  // kernels are being compiled.
  bool take_first_turn() {
    return take_turn([this](std::size_t map, Progress& progress) {
      work_({map, device_, &progress, turns_.threads, stdout, stderr});
      return std::make_unique<HeldOutput>();
    });
  }

  void work_off(Device& device) {
    const int threads = std::max(1, turns_.threads / turns_.at_once);
    const auto hold = [&](std::size_t map, Progress& progress) {
      auto held = std::make_unique<HeldOutput>();
      const LogScope scope({held.get(), nullptr});
      work_({map, device, &progress, threads, held->out(), held->err()});
      return held;
    };
    while (take_turn(hold)) continue;
  }

  // Works on the next map. Returns false if there is none, or if the work is cancelled.
  template <typename Work>
  bool take_turn(const Work& work) {
    const std::size_t map = next_++;
    if (map >= turns_.count || progress_.is_cancelled()) return false;
    return guard([&] {
      Progress progress = progress_.of_map(map);
      std::unique_ptr<HeldOutput> held = work(map, progress);
      progress_.finish_map(map);
      show_in_order(map, std::move(held));
    });
  }

  // Shows the output of this map, and of later ones that waited for it, if all maps before it have been shown.
  void show_in_order(std::size_t map, std::unique_ptr<HeldOutput> held) {
    const std::lock_guard lock(show_mutex_);
    held_[map] = std::move(held);
    for (; shown_ < held_.size() && held_[shown_]; ++shown_) std::exchange(held_[shown_], nullptr)->show();
  }

  template <typename Body>
  bool guard(const Body& body) {
    try {
      body();
      return true;
    } catch (...) {
      const std::lock_guard lock(show_mutex_);
      if (!failure_) failure_ = std::current_exception();
      progress_.cancel();
      return false;
    }
  }

  const MapTurns& turns_;
  Device& device_;
  const std::function<void(const MapTurn&)>& work_;
  SharedProgress progress_;
  std::atomic<std::size_t> next_{0};
  std::mutex show_mutex_;
  std::vector<std::unique_ptr<HeldOutput>> held_;  // [map], null if the map is not finished or has been shown
  std::size_t shown_ = 0;                          // number of maps whose output has been shown
  std::exception_ptr failure_;
};

}  // namespace

void for_each_map(const MapTurns& turns, const CommonOptions& common, Device& device,
                  const std::function<void(const MapTurn& turn)>& work) {
  MULTUM_CHECK(turns.at_once >= 1);
  if (turns.at_once > 1) return SeveralTurns(turns, common, device, work).run();
  for (std::size_t map = 0; map < turns.count; ++map) {
    openjd_part(map, turns.count);
    const auto progress = make_progress(common);
    work({map, device, progress.get(), turns.threads, stdout, stderr});
  }
}

}  // namespace multum
