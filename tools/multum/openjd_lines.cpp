// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/openjd_lines.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>

#include "host/foundation/base/error.h"
#include "host/foundation/base/shown_text.h"

namespace multum {
namespace {

struct Parts {
  double part = 0.0, of = 1.0;
};

bool& is_on() {
  static bool on = false;
  return on;
}

Parts& parts() {
  static Parts one;
  return one;
}

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

// Prints at most one line per second. On coarse levels, stages change often, and a log keeps every line.
class OpenJdPrinter {
 public:
  void show(const ProgressEvent& event) {
    const auto now = std::chrono::steady_clock::now();
    const bool is_done = event.units_total > 0 && event.units_done >= event.units_total;
    if (last_ && now - *last_ < std::chrono::seconds(1) && !is_done) return;
    const double own =
        event.units_total == 0
            ? 0.0
            : std::min(1.0, static_cast<double>(event.units_done) / static_cast<double>(event.units_total));
    const double percent = 100.0 * (parts().part + own) / parts().of;
    if (last_ && percent <= percent_ && event.stage == stage_) return;
    last_ = now;
    percent_ = percent;
    if (event.stage != stage_ && !event.stage.empty())
      print_shown(stdout, "openjd_status: %s\n", one_line(event.stage).c_str());
    stage_ = event.stage;
    print_shown(stdout, "openjd_progress: %.1f\n", percent);
    std::fflush(stdout);
  }

 private:
  std::optional<std::chrono::steady_clock::time_point> last_;
  double percent_ = 0.0;
  std::string stage_;
};

}  // namespace

void begin_openjd_lines() { is_on() = true; }
bool has_openjd_lines() { return is_on(); }

void openjd_part(std::size_t part, std::size_t of) {
  parts() = {static_cast<double>(part), static_cast<double>(std::max<std::size_t>(of, 1))};
}

std::unique_ptr<Progress> make_openjd_progress() {
  const auto signals = std::shared_ptr<Progress>(make_terminal_progress(false));
  return std::make_unique<Progress>([signals, printer = std::make_shared<OpenJdPrinter>()](const ProgressEvent& event) {
    printer->show(event);
    // finish() ignores a returned false, because it is too late to cancel when the work is done, but it does not ignore
    // an exception.
    try {
      signals->advance(0);
    } catch (const Cancelled&) {
      return false;
    }
    return true;
  });
}

void print_openjd_success() {
  print_shown(stdout, "openjd_progress: 100.0\n");
  std::fflush(stdout);
}

void print_openjd_failure(const std::string& why) {
  print_shown(stdout, "openjd_fail: %s\n", one_line(why).c_str());
  std::fflush(stdout);
}

}  // namespace multum
