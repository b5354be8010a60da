// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/messages/stream_turn.h"

#include <cstdio>

namespace multum {
namespace {

constexpr char kWipe[] = "\r\033[K";
constexpr std::size_t kLongestLine = std::size_t{1} << 16;  // longer lines are written in parts

std::mutex g_mutex;
bool g_has_bar = false;

void wipe_bar() {
  if (g_has_bar) std::fputs(kWipe, stderr);
  g_has_bar = false;
}

}  // namespace

void begin_whole_lines() {
  static char buffer[kLongestLine];
  std::setvbuf(stdout, buffer, _IOLBF, sizeof(buffer));
}

StreamTurn::StreamTurn() : lock_(g_mutex) { wipe_bar(); }

void show_bar(const std::string& bar) {
  const std::lock_guard<std::mutex> lock(g_mutex);
  const std::string text = kWipe + bar;
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
  g_has_bar = true;
}

}  // namespace multum
