// SPDX-License-Identifier: Apache-2.0
// Tests the numbers of files: where they end, what is refused, and that a decimal comma in the locale changes nothing.
#include "host/foundation/base/leading_number.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/foundation/base/comma_locale.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

TEST(LeadingNumberTest, EndsWhereTheNumberEnds) {
  std::string_view rest = "untouched";
  EXPECT_FALSE(leading_number("", &rest));
  EXPECT_FALSE(leading_number("red 1", &rest));
  EXPECT_FALSE(leading_number("+-1", &rest));
  EXPECT_FALSE(leading_number("1e999", &rest)) << "beyond the range of double";
  EXPECT_EQ(rest, "untouched");
  EXPECT_EQ(leading_number(" \t+2.5e1 m", &rest), 25.0);
  EXPECT_EQ(rest, " m");
  EXPECT_EQ(leading_number("0,5", &rest), 0.0);
  EXPECT_EQ(rest, ",5");
  EXPECT_EQ(leading_number("-.5", &rest), -0.5);
  EXPECT_EQ(rest, "");
  EXPECT_TRUE(std::isinf(leading_number("inf").value()));
}

TEST(LeadingNumberTest, DoesNotDependOnTheLocale) {
  const testing::TemporaryFolder folder;
  const testing::CommaLocale locale(folder.path());
  if (!locale.is_set()) GTEST_SKIP() << "no locale with a decimal comma, and localedef cannot make one";
  EXPECT_EQ(leading_number("2.5"), 2.5);
}

}  // namespace
}  // namespace multum
