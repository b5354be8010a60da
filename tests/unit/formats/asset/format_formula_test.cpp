// SPDX-License-Identifier: Apache-2.0
// Tests the formulas of docs/reference/file_format.md with the numbers on that page.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

// Returns the mean cosine of a vMF lobe, coth(kappa) - 1/kappa.
double mean_cosine(double kappa) { return kappa < 1e-4 ? kappa / 3.0 : 1.0 / std::tanh(kappa) - 1.0 / kappa; }

TEST(FormatFormulaTest, KappaOfAMeanCosine) {
  const std::string page = testing::read_bytes(std::string(MULTUM_SOURCE_DIR) + "/docs/reference/file_format.md");
  const std::size_t line = page.find("    p = ");
  ASSERT_NE(line, std::string::npos);
  double p0 = 0.0, p1 = 0.0, p2 = 0.0, p3 = 0.0;
  ASSERT_EQ(std::sscanf(page.c_str() + line, " p = %lf + x (%lf + x (%lf + x %lf))", &p0, &p1, &p2, &p3), 4);
  double worst = 0.0;
  for (double kappa = 1e-3; kappa < 1e6; kappa *= 1.01) {
    const double a = mean_cosine(kappa), q = 1.0 - a, x = a * a;
    const double p = p0 + x * (p1 + x * (p2 + x * p3));
    const double found = a * (3.0 - x + x * (1.0 - x) * p) / (q * (2.0 - q));
    worst = std::max(worst, std::abs(found / kappa - 1.0));
  }
  EXPECT_LT(worst, 2.35e-4);
  EXPECT_GT(worst, 2.2e-4) << "the page states the formula's error";
}

}  // namespace
}  // namespace multum
