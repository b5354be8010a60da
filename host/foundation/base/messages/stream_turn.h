// SPDX-License-Identifier: Apache-2.0
// Keeps stdout, stderr and the bar of progress from running into one another where they go to one terminal, pipe or
// file: stdout gives out whole lines only, one thread writes at a time, and a bar is wiped before any line.
#pragma once

#include <mutex>
#include <string>

namespace multum {

/// From here on stdout gives out lines as soon as they are whole, also into pipes and files, and never parts of them.
/// Called once, before anything is written.
void begin_whole_lines();

/// The right to write to stdout or stderr while it lives. Wipes the bar.
class StreamTurn {
 public:
  StreamTurn();
  StreamTurn(const StreamTurn&) = delete;
  StreamTurn& operator=(const StreamTurn&) = delete;

 private:
  std::lock_guard<std::mutex> lock_;
};

/// Shows a bar on stderr, a terminal, in place of the one before. Control characters are the caller's matter.
void show_bar(const std::string& bar);

}  // namespace multum
