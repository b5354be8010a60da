// SPDX-License-Identifier: Apache-2.0
// Tests that materials repeat, have values in range, and differ with the seed.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "host/formats/testmap/materials/test_material.h"

namespace multum::testing {
namespace {

class MaterialTest : public ::testing::TestWithParam<std::pair<const char*, MaterialKind>> {};

TEST_P(MaterialTest, RepeatsWithValuesInRange) {
  const auto material = make_material(GetParam().second, 7), other = make_material(GetParam().second, 8);
  double most = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double u = (i % 63 + 0.3) / 63.0, v = (i / 63 + 0.6) / 64.0;
    const MaterialPoint here = material->at(u, v), right = material->at(u + 1.0, v), below = material->at(u, v + 1.0);
    EXPECT_NEAR(here.height, right.height, 1e-9);
    EXPECT_NEAR(here.height, below.height, 1e-9);
    EXPECT_LT(glm::length(here.colour - right.colour), 1e-6);
    EXPECT_LT(glm::length(here.colour - below.colour), 1e-6);
    EXPECT_LT(std::abs(here.height), 0.2);
    EXPECT_EQ(glm::clamp(here.colour, 0.0, 1.0), here.colour);
    EXPECT_EQ(std::clamp(here.roughness, 0.02, 1.0), here.roughness);
    EXPECT_EQ(std::clamp(here.metalness, 0.0, 1.0), here.metalness);
    const MaterialPoint elsewhere = other->at(u, v);
    most = std::max({most, std::abs(here.height - elsewhere.height), glm::length(here.slope - elsewhere.slope)});
  }
  EXPECT_GT(most, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(All, MaterialTest, ::testing::ValuesIn(kMaterialKinds.begin(), kMaterialKinds.end()),
                         [](const auto& one) {
                           std::string name = one.param.first;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace multum::testing
