// SPDX-License-Identifier: Apache-2.0
// Tests the formula of each engine for roughness where normals change.
#include "host/delivery/forms/engine_filter.h"

#include <gtest/gtest.h>

#include <cmath>

namespace multum {
namespace {

const glm::dvec3 kAlongX(0.1, -0.2, 0.05), kAlongY(-0.02, 0.0, 0.15);
constexpr double kSquareX = 0.0525, kSquareY = 0.0229;

EngineRoughness roughness_for(Engine engine, double roughness) {
  return engine_roughness(filter_of(engine), roughness, kAlongX, kAlongY);
}

TEST(EngineFilterTest, EachEngineWidensAsItsShaderDoes) {
  EXPECT_NEAR(roughness_for(Engine::kThree, 0.3).lights, 0.3 + 0.2, 1e-12);
  EXPECT_NEAR(roughness_for(Engine::kThree, 0.0).lights, 0.045 + 0.2, 1e-12);
  EXPECT_EQ(roughness_for(Engine::kThree, 0.9).lights, 1.0);
  EXPECT_NEAR(std::pow(roughness_for(Engine::kFilament, 0.3).lights, 4.0),
              std::pow(0.3, 4.0) + 2.0 * 0.15 * (kSquareX + kSquareY), 1e-12);
  EXPECT_NEAR(std::pow(roughness_for(Engine::kGodot, 0.3).lights, 2.0),
              std::pow(0.3, 2.0) + 2.0 * 0.25 * (kSquareX + kSquareY), 1e-12);
  const EngineRoughness babylon = roughness_for(Engine::kBabylon, 0.3);
  EXPECT_NEAR(babylon.lights, std::cbrt(kSquareX), 1e-12);
  EXPECT_NEAR(std::pow(babylon.surroundings, 2.0), 0.09 + 0.75 * std::sqrt(kSquareX), 1e-12);
  EXPECT_EQ(roughness_for(Engine::kBabylon, 0.5).lights, 0.5) << "the rougher of both";
}

TEST(EngineFilterTest, WhatIsAddedHasALimit) {
  const glm::dvec3 steep(2.0, 0.0, 0.0);
  const auto at = [&](Engine engine) { return engine_roughness(filter_of(engine), 0.3, steep, steep).lights; };
  EXPECT_NEAR(std::pow(at(Engine::kFilament), 4.0), std::pow(0.3, 4.0) + 0.2, 1e-12);
  EXPECT_NEAR(std::pow(at(Engine::kGodot), 2.0), std::pow(0.3, 2.0) + 0.18, 1e-12);
}

TEST(EngineFilterTest, ThoseWithoutATermLeaveRoughnessAsItIs) {
  for (const Engine engine : {Engine::kPlayCanvas, Engine::kUnity, Engine::kUnreal}) {
    EXPECT_EQ(roughness_for(engine, 0.3).lights, 0.3);
    EXPECT_EQ(roughness_for(engine, 0.3).surroundings, 0.3);
  }
}

}  // namespace
}  // namespace multum
