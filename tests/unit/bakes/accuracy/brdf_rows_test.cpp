// SPDX-License-Identifier: Apache-2.0
// Tests powers of cosines, which are computed as products. The plan reaches every exponent, and rows follow the plan
// bit for bit with every size of vector register.
#include "host/bakes/accuracy/brdf_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

namespace multum {
namespace {

// Returns the exponents of all powers in a plan.
std::vector<double> exponents_of(const PowerPlan& plan) {
  std::vector<double> exponents = {1.0};
  for (const PowerProduct& product : plan.products) {
    const auto first = static_cast<std::size_t>(product.first), second = static_cast<std::size_t>(product.second);
    EXPECT_LT(first, exponents.size());
    EXPECT_LT(second, exponents.size());
    exponents.push_back(exponents.at(first) + exponents.at(second));
  }
  return exponents;
}

void expect_reached(const std::vector<double>& exponents) {
  const PowerPlan plan = plan_powers(exponents);
  const std::vector<double> reached = exponents_of(plan);
  ASSERT_EQ(plan.whole.size(), exponents.size());
  for (std::size_t e = 0; e < exponents.size(); ++e) {
    EXPECT_EQ(plan.whole[e] >= 0, exponents[e] == std::floor(exponents[e]) && exponents[e] <= 1e6);
    if (plan.whole[e] >= 0) {
      EXPECT_EQ(reached.at(static_cast<std::size_t>(plan.whole[e])), exponents[e]);
    }
  }
}

TEST(PowerPlanTest, ReachesEveryExponent) {
  expect_reached({1.0});
  expect_reached({500.0, 20.0, 100.0, 20.0, 1.0, 2.5, 0.5, 1e7});
  for (int s = 1; s < 300; ++s) expect_reached({static_cast<double>(s)});
  std::mt19937 random(1);
  for (int round = 0; round < 100; ++round) {
    std::vector<double> exponents(1 + random() % 6);
    for (double& s : exponents) s = static_cast<double>(1 + random() % 100000);
    expect_reached(exponents);
  }
}

TEST(PowerPlanTest, SharesProducts) {
  EXPECT_EQ(plan_powers({20.0, 100.0, 500.0}).products.size(), 11u);
  EXPECT_EQ(plan_powers({1.0}).products.size(), 0u);
  EXPECT_EQ(plan_powers({64.0}).products.size(), 6u);
}

TEST(BrdfRowsTest, EqualPlainProductsBitForBit) {
  const std::vector<double> exponents = {500.0, 20.0, 1.0, 20.0, 7.25, 100.0, 1.0};
  const glm::dvec3 omega = glm::normalize(glm::dvec3(0.4, -0.3, 0.6));
  const PowerPlan plan = plan_powers(exponents);
  std::mt19937 random(2);
  for (const int count : {1, 7, 127, 128, 129, 1000}) {
    std::array<std::vector<float>, 3> n;
    for (int i = 0; i < count; ++i)
      for (std::vector<float>& plane : n)
        plane.push_back(static_cast<float>(static_cast<double>(random() >> 8) * 0x1p-23 - 1.0) * 0.57f);
    constexpr double kPoison = -7.0;
    std::vector<std::vector<double>> found(exponents.size(),
                                           std::vector<double>(static_cast<std::size_t>(count) + 1, kPoison));
    std::vector<double*> rows;
    for (std::vector<double>& row : found) rows.push_back(row.data());
    BrdfRows(omega, exponents).evaluate({n[0].data(), n[1].data(), n[2].data()}, count, rows);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      const double t = omega.x * static_cast<double>(n[0][i]) + omega.y * static_cast<double>(n[1][i]) +
                       omega.z * static_cast<double>(n[2][i]);
      std::vector<double> powers = {t > 0.0 ? t : 0.0};
      for (const PowerProduct& product : plan.products)
        powers.push_back(powers[static_cast<std::size_t>(product.first)] *
                         powers[static_cast<std::size_t>(product.second)]);
      for (std::size_t e = 0; e < exponents.size(); ++e) {
        const double exact = std::pow(powers[0], exponents[e]);
        const double plain = plan.whole[e] >= 0 ? powers[static_cast<std::size_t>(plan.whole[e])] : exact;
        ASSERT_EQ(found[e][i], plain) << exponents[e];
        // If two factors have m and n roundings, their product has m + n + 1 roundings.
        EXPECT_NEAR(plain, exact, exponents[e] * std::numeric_limits<double>::epsilon() * exact + 1e-300);
      }
    }
    for (const std::vector<double>& row : found) EXPECT_EQ(row.back(), kPoison);
  }
}

}  // namespace
}  // namespace multum
