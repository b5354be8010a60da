// SPDX-License-Identifier: Apache-2.0
// Separates stdout, stderr and the progress bar when they go to the same terminal, pipe or file. Stdout writes only
// whole lines, one thread writes at a time, and the bar is erased before a line is written.
#pragma once

#include <mutex>
#include <string>

namespace multum {

/// Makes stdout write only complete lines, as soon as they are complete, even to pipes and files. Call it once, before
/// any output.
void begin_whole_lines();

/// Gives this thread the exclusive right to write to stdout or stderr while the object exists. Erases the progress bar.
class StreamTurn {
 public:
  StreamTurn();
  StreamTurn(const StreamTurn&) = delete;
  StreamTurn& operator=(const StreamTurn&) = delete;

 private:
  std::lock_guard<std::mutex> lock_;
};

/// Replaces the bar on stderr, which must be a terminal. The caller removes control characters.
void show_bar(const std::string& bar);

}  // namespace multum
