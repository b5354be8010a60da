// SPDX-License-Identifier: Apache-2.0
// Tests the cache of per-BRDF data. An entry is made once for several users and does not depend on colours, and the
// cache keeps only a few entries.
#include "runtime_gl/render/kept_of_brdf.h"

#include <gtest/gtest.h>

namespace {

using multum::Brdf;
using multum::gl::KeptOfBrdf;

Brdf of_exponent(float exponent) {
  Brdf brdf;
  brdf.exponent = exponent;
  return brdf;
}

// Makes exponents and counts the calls.
struct Maker {
  int made = 0;
  float of(KeptOfBrdf<float>& kept, const Brdf& brdf) {
    return kept.of(brdf, [this](const Brdf& one) {
      ++made;
      return one.exponent;
    });
  }
};

TEST(KeptOfBrdfTest, ObjectsOfSeveralBrdfsMakeEachOnce) {
  KeptOfBrdf<float> kept;
  Maker maker;
  for (int frame = 0; frame < 5; ++frame)
    for (int i = 0; i < static_cast<int>(kept.kMost); ++i) {
      const auto exponent = static_cast<float>(10 + i);
      EXPECT_EQ(maker.of(kept, of_exponent(exponent)), exponent);
    }
  EXPECT_EQ(maker.made, static_cast<int>(kept.kMost));
}

TEST(KeptOfBrdfTest, ColoursMakeNoOther) {
  KeptOfBrdf<float> kept;
  Maker maker;
  Brdf red = of_exponent(50.0f);
  red.diffuse = red.specular = glm::vec3(1.0f, 0.0f, 0.0f);
  EXPECT_EQ(maker.of(kept, of_exponent(50.0f)), 50.0f);
  EXPECT_EQ(maker.of(kept, red), 50.0f);
  EXPECT_EQ(maker.made, 1);
}

TEST(KeptOfBrdfTest, TheLeastUsedIsForgotten) {
  KeptOfBrdf<float> kept;
  Maker maker;
  const int most = static_cast<int>(kept.kMost);
  for (int i = 0; i < most; ++i) maker.of(kept, of_exponent(static_cast<float>(1 + i)));
  maker.of(kept, of_exponent(1.0f));  // is used again, so that 2 is now the oldest entry
  maker.of(kept, of_exponent(1e3f));  // replaces 2
  EXPECT_EQ(maker.made, most + 1);
  maker.of(kept, of_exponent(1.0f));
  EXPECT_EQ(maker.made, most + 1);
  EXPECT_EQ(maker.of(kept, of_exponent(2.0f)), 2.0f);
  EXPECT_EQ(maker.made, most + 2);
}

}  // namespace
