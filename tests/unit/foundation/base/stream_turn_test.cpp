// SPDX-License-Identifier: Apache-2.0
// Tests stdout and stderr that go to the same file. No line of either stream is split, whichever threads write.
// Warnings name their subject.
#include "host/foundation/base/messages/stream_turn.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <sstream>
#include <thread>

#include "host/foundation/base/log.h"
#include "host/foundation/base/messages/held_warnings.h"
#include "host/foundation/base/shown_text.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::read_bytes;
using testing::TemporaryFolder;

// Sends both streams to one file, as 2>&1 does. Returns the text of the file.
template <typename Writing>
std::string written_by(const Writing& writing) {
  const TemporaryFolder folder;
  const std::string path = folder / "both";
  std::fflush(stdout);
  const int usual[2] = {dup(STDOUT_FILENO), dup(STDERR_FILENO)};
  const int file = open(path.c_str(), O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC, 0600);
  dup2(file, STDOUT_FILENO);
  dup2(file, STDERR_FILENO);
  begin_whole_lines();
  writing();
  std::fflush(stdout);
  dup2(usual[0], STDOUT_FILENO);
  dup2(usual[1], STDERR_FILENO);
  for (const int descriptor : {usual[0], usual[1], file}) close(descriptor);
  return read_bytes(path);
}

TEST(StreamTurnTest, AHalfLineWaitsForItsEnd) {
  EXPECT_EQ(written_by([] {
              write_shown(stdout, "first\nsecond, ");
              log_warning("a.png", "is doubtful");
              print_shown(stderr, "multum: b.png: cannot be read\n");
              write_shown(stdout, "as a whole\n");
            }),
            "first\nwarning: a.png: is doubtful\nmultum: b.png: cannot be read\nsecond, as a whole\n");
}

// The text is much longer than a buffer of the C library.
TEST(StreamTurnTest, NoLineIsSplitByAnother) {
  const std::string result = std::string(300, 'r') + " end of the result", message = std::string(200, 'm') + " end";
  constexpr int kCount = 400;
  const std::string text = written_by([&] {
    std::thread messages([&] {
      for (int i = 0; i < kCount; ++i) log_warning("a.png", message);
    });
    for (int i = 0; i < kCount; ++i) {
      write_shown(stdout, std::string_view(result).substr(0, 150));
      write_shown(stdout, std::string(result.substr(150)) + "\n" + result + "\n");
    }
    messages.join();
  });
  std::istringstream lines(text);
  int results = 0, warnings = 0;
  for (std::string line; std::getline(lines, line);) {
    const bool is_warning = line == "warning: a.png: " + message;
    ASSERT_TRUE(is_warning || line == result) << line;
    ++(is_warning ? warnings : results);
  }
  EXPECT_EQ(results, 2 * kCount);
  EXPECT_EQ(warnings, kCount);
}

TEST(StreamTurnTest, ABarIsWipedBeforeALine) {
  EXPECT_EQ(written_by([] {
              show_bar("[##..]");
              show_bar("[###.]");
              log_warning("a.png", "is doubtful");
              write_shown(stdout, "done\n");
            }),
            "\r\033[K[##..]\r\033[K[###.]\r\033[Kwarning: a.png: is doubtful\ndone\n");
}

TEST(StreamTurnTest, HeldWarningsKeepTheirSubject) {
  HeldWarnings held;
  log_warning("a.png", "is doubtful");
  log_named_warning("b.png: too");
  EXPECT_EQ(held.take(), (std::vector<std::string>{"a.png: is doubtful", "b.png: too"}));
}

}  // namespace
}  // namespace multum
