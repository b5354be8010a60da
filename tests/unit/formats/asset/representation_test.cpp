// SPDX-License-Identifier: Apache-2.0
// Tests the rows of the table of representations.
#include "host/formats/asset/representation.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include <glm/geometric.hpp>

#include "host/formats/asset/lobes/lobe_family.h"

namespace multum {
namespace {

TEST(RepresentationTest, RowsAreWhole) {
  std::set<std::string> options, names, contents;
  for (const RepresentationInfo& info : representations()) {
    SCOPED_TRACE(info.name);
    EXPECT_EQ(&representation_info(info.representation), &info);
    EXPECT_TRUE(options.insert(info.option).second && names.insert(info.name).second &&
                contents.insert(info.contents).second);
    EXPECT_FALSE(info.encodings.empty());
    EXPECT_EQ(holds_lobes(info.representation), info.lobes != nullptr);
    EXPECT_EQ(info.has_kappa, info.lobes != nullptr && !info.lobes->is_planar);
    EXPECT_FALSE(info.has_order && info.lobes != nullptr);
  }
}

// By docs/reference/file_format.md there is one texture per lobe, two for moments, and one per four coefficients.
// Features take one texture per lobe, or one for the whole texel.
TEST(RepresentationTest, TexturesAreThoseOfTheFormat) {
  const TexelCounts counts{.lobes = 3, .sh_order = 4};
  const auto textures = [&](const char* name, int features) {
    for (const RepresentationInfo& info : representations())
      if (std::string(info.name) == name) return texture_count(info.representation, counts, features);
    return -1;
  };
  for (const char* lobes : {"movmf", "gmm"}) {
    EXPECT_EQ(textures(lobes, 0), 3);
    EXPECT_EQ(textures(lobes, 2), 9);
  }
  EXPECT_EQ(textures("moments", 0), 2);
  EXPECT_EQ(textures("moments", 2), 4);
  EXPECT_EQ(textures("sh", 0), 6) << "24 coefficients: the first is a constant";
  EXPECT_EQ(textures("sh", 2), 8);
}

// Level 0 stores a normal in the form of its representation and returns it in the form that all representations share.
TEST(RepresentationTest, FinestNormalsComeBack) {
  const glm::vec3 normal = glm::normalize(glm::vec3(0.3f, -0.5f, 0.8f));
  for (const LobeFamily* family : {&kSphericalLobes, &kPlanarLobes}) {
    SCOPED_TRACE(family->plural);
    glm::vec3 stored = family->finest_of_normal(normal, false);
    EXPECT_TRUE(family->is_single_direction(stored, false));
    EXPECT_LT(glm::distance(family->normal_of_finest(stored, false), normal), 1e-6f);
    family->quantize_finest(&stored, 1, StorageEncoding::kSnorm16);
    EXPECT_EQ(stored.z, family->finest_third(stored.x, stored.y, StorageEncoding::kSnorm16));
    EXPECT_LT(glm::distance(family->normal_of_finest(stored, false), normal), 1e-4f);
    const glm::vec3 shortened = family->finest_of_normal(0.9f * normal, true);
    EXPECT_FALSE(family->is_single_direction(shortened, false)) << "has a width";
    EXPECT_TRUE(family->is_single_direction(shortened, true));
    EXPECT_LT(glm::distance(family->normal_of_finest(shortened, true), 0.9f * normal), 1e-5f);
  }
}

}  // namespace
}  // namespace multum
