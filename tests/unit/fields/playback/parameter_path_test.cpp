// SPDX-License-Identifier: Apache-2.0
// Tests paths that are given as text: the values of expressions, and the error messages.
#include "host/fields/playback/parameter_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

const std::vector<std::string> kPathNames = {"view", "light"};

std::vector<double> values(const std::string& text, double seconds, double share) {
  return ParameterPath(text, kPathNames).at({seconds, share});
}

TEST(ParameterPath, Evaluates) {
  const double t = 0.7;
  const struct {
    const char* text;
    double expected;
  } cases[] = {{"1+2*3", 7.0},
               {"(1+2)*3", 9.0},
               {"8/4/2", 1.0},
               {"8-4-2", 2.0},
               {"-2*-3", 6.0},
               {"2--3", 5.0},
               {"4+3*sin(t)", 4.0 + 3.0 * std::sin(t)},
               {" cos ( 2 * pi * t ) ", std::cos(2.0 * M_PI * t)},
               {"0..63", 63.0 * 0.25},
               {"63 .. 0", 63.0 * 0.75},
               {"1.5..2.5", 1.75},
               {".5..-.5", 0.25},
               {"t..2*t+1", t + (t + 1.0) * 0.25},
               {"7.", 7.0},
               {"0.125", 0.125}};
  for (const auto& one : cases)
    EXPECT_NEAR(values(std::string("light=") + one.text, t, 0.25)[1], one.expected, 1e-12) << one.text;
}

TEST(ParameterPath, ParametersAreNamedInAnyOrderAndOthersStayAtZero) {
  EXPECT_EQ(values("light=2, view = 5", 0.0, 0.0), (std::vector<double>{5.0, 2.0}));
  EXPECT_EQ(values("view=3", 0.0, 0.0), (std::vector<double>{3.0, 0.0}));
}

TEST(ParameterPath, RefusesWhatItDoesNotUnderstand) {
  const struct {
    std::string text;
    std::vector<std::string> parts;
  } cases[] = {{"", {"the end", "NAME=VALUE"}},
               {"view", {"'view'", "NAME=VALUE"}},
               {"vew=1", {"unknown parameter 'vew'", "did you mean 'view'", "view, light"}},
               {"view=1,view=2", {"'view' twice"}},
               {"view=", {"the end", "a number"}},
               {"view=1+", {"the end", "a number"}},
               {"view=(1", {"the end", "')'"}},
               {"view=1)", {"')' at character 7", "the end"}},
               {"view=sin 1", {"'1'", "'('"}},
               {"view=exp(1)", {"'exp(1)'", "sin, cos"}},
               {"view=1 2", {"'2' at character 8"}},
               {"view=1..2..3", {"'..3'"}},
               {"view=.", {"a number"}},
               {"view=1e5", {"'e5'"}},
               {"view=1,", {"NAME=VALUE"}},
               {"view=__import__", {"'__import__'"}},
               {"view=" + std::string(200, '('), {"at most 64"}},
               {"view=" + std::string(200, '-') + "1", {"at most 64"}},
               {"view=" + std::string(5000, '1'), {"5005 characters", "4096"}}};
  for (const auto& one : cases)
    testing::expect_error(ErrorCode::kUsage, one.parts, [&] { values(one.text, 0.0, 0.0); });
  testing::expect_error(ErrorCode::kUsage, {"'light'", "finite"}, [&] { values("light=1/t", 0.0, 0.0); });
}

}  // namespace
}  // namespace multum
