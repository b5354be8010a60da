// SPDX-License-Identifier: Apache-2.0
// Tests paths that the player in the browser recorded. They must give the same points as in
// tests/player/modules_test.mjs, and errors must have the expected messages.
#include "host/fields/playback/recorded_path.h"

#include <gtest/gtest.h>

#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

const std::vector<std::string> kRecordedNames = {"view", "light"};

std::string path_text(const std::string& positions, const std::string& parameters = R"(["view","light"])") {
  return R"({"multumPath":1,"parameters":)" + parameters + R"(,"positions":)" + positions + "}";
}

TEST(RecordedPath, GoesThroughItsPositionsAndBeginsAgain) {
  const RecordedPath path = read_recorded_path(MULTUM_RECORDED_PATH, kRecordedNames);
  EXPECT_EQ(path.seconds(), 2.5);
  const struct {
    double seconds;
    std::vector<double> at;
  } cases[] = {{0.0, {0.0, 1.0}},  {0.25, {0.5, 1.0}}, {0.5, {2.0, 0.0}},
               {1.5, {1.0, 0.25}}, {2.5, {0.0, 1.0}},  {2.75, {0.5, 1.0}}};
  for (const auto& one : cases) EXPECT_EQ(path.at(one.seconds), one.at) << one.seconds;
}

TEST(RecordedPath, OfNoLengthStaysWhereItBegins) {
  const RecordedPath path(path_text("[[3,1,2],[3,4,5]]"), kRecordedNames);
  EXPECT_EQ(path.seconds(), 0.0);
  for (const double seconds : {0.0, 7.0}) EXPECT_EQ(path.at(seconds), (std::vector<double>{1.0, 2.0}));
}

TEST(RecordedPath, RefusesWhatIsNone) {
  const struct {
    std::string text;
    std::vector<std::string> parts;
  } cases[] = {{"", {"not JSON"}},
               {"{\"multumPath\":1,", {"not JSON"}},
               {"[1]", {"not a path", "\"multumPath\": 1"}},
               {"{}", {"not a path"}},
               {R"({"multumPath":2})", {"\"multumPath\": 2", "expected 1"}},
               {R"({"multumPath":1})", {"through null", R"(["view","light"])"}},
               {path_text("[[0,0,0],[1,1,1]]", R"(["light","view"])"), {R"(["light","view"])", R"(["view","light"])"}},
               {path_text("7"), {"has 0 positions", "2 to 100000"}},
               {path_text("[[0,0,0]]"), {"has 1 positions"}},
               {path_text("[[0,0,0],[1,1]]"), {"position 1 is [1,1]", "3 numbers"}},
               {path_text("[[0,0,\"1\"],[1,1,1]]"), {"position 0 is"}},
               {path_text("[[0,0,null],[1,1,1]]"), {"position 0 is"}},
               {path_text("[[0,0,1e999],[1,1,1]]"), {"not JSON"}},
               {path_text("[[-1e308,0,0],[1e308,1,1]]"), {"finite number of seconds"}},
               {path_text("[[2,0,0],[1,1,1]]"), {"position 1 is at 1 s", "2 s"}}};
  for (const auto& one : cases)
    testing::expect_error(ErrorCode::kInput, one.parts, [&] { RecordedPath(one.text, kRecordedNames); });
  testing::expect_error(ErrorCode::kInput, {"nowhere.json"},
                        [] { read_recorded_path("nowhere.json", kRecordedNames); });
}

}  // namespace
}  // namespace multum
