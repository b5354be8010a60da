// SPDX-License-Identifier: Apache-2.0
// Compares exp_of_negative() with the exponential function of long double.
#include "host/foundation/base/vector_exp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace multum::testing {
namespace {

// The C library's exp for long double has 11 more bits.
TEST(VectorExpTest, RelativeErrorIsSmall) {
  long double worst = 0.0L;
  for (double x = 0.0; x > -700.0; x -= 0.00317) {
    const long double exact = std::exp(static_cast<long double>(x));
    worst = std::max(worst, std::abs(static_cast<long double>(exp_of_negative(x)) / exact - 1.0L));
  }
  EXPECT_LE(worst, 4e-16L);
  EXPECT_GT(worst, 0.0L);
}

TEST(VectorExpTest, Limits) {
  EXPECT_EQ(exp_of_negative(0.0), 1.0);
  EXPECT_EQ(exp_of_negative(-0.0), 1.0);
  EXPECT_EQ(exp_of_negative(-1e9), exp_of_negative(-700.0));
  EXPECT_EQ(exp_of_negative(-std::numeric_limits<double>::infinity()), exp_of_negative(-700.0));
  EXPECT_GT(exp_of_negative(-700.0), 0.0);
}

}  // namespace
}  // namespace multum::testing
