// SPDX-License-Identifier: Apache-2.0
// Tests files with weights and with roughness, in both representations. They must be the same after writing and
// reading, and damage must be found. Programs that do not know weights and roughness refuse such files, and other files
// do not change.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <vector>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/lobes/gmm_quantize.h"
#include "host/formats/asset/lobes/movmf_verify.h"
#include "tests/unit/formats/asset/movmf_test_mipmap.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::TemporaryFolder;
using testing::uniform;

struct MaterialCase {
  StorageEncoding encoding;
  bool has_colours, has_roughness;
  int weight_count;
  Representation lobes = Representation::kMovmf;
};

// Without this function, the name of a test would contain the bytes of its case, including padding.
void PrintTo(const MaterialCase& c, std::ostream* out) {
  *out << representation_info(c.lobes).option << " as " << static_cast<int>(c.encoding)
       << (c.has_colours ? " colours" : "") << (c.has_roughness ? " roughness" : "") << " weights " << c.weight_count;
}

std::set<std::string> failed(const std::string& path) {
  std::set<std::string> names;
  for (const VerifyFinding& finding : verify_baked(path, 2))
    if (!finding.passed) names.insert(finding.check);
  return names;
}

class MaterialFileTest : public ::testing::TestWithParam<MaterialCase> {
 protected:
  MovmfMipmap lobes() const {
    const MaterialCase& c = GetParam();
    MovmfMipmap mipmap = testing::random_mipmap(19, 13, 3, c.has_colours, c.encoding, 8);
    std::mt19937 random(9);
    mipmap.header.representation = c.lobes;
    mipmap.header.weight_count = c.weight_count;
    mipmap.header.has_roughness = c.has_roughness;
    mipmap.header.mean_cosine = c.has_roughness ? 0.75f : 1.0f;
    for (MovmfLevel& level : mipmap.levels) {
      for (std::size_t j = 0; j < level.lobes.size(); ++j) {
        if (c.weight_count > 0) level.weights.emplace_back();
        for (glm::vec4& lobe : level.lobes[j]) {
          if (c.has_roughness)
            lobe = glm::vec4(glm::vec3(lobe) * (1.0f - 0.5f * static_cast<float>(uniform(random))), lobe.w);
          if (c.lobes == Representation::kGmm && lobe.w > 0.0f) lobe = as_gaussian(lobe);
          for (int k = 0; k < c.weight_count; ++k)
            level.weights[j].push_back(lobe.w * static_cast<float>(uniform(random)));
        }
      }
    }
    quantize_movmf(mipmap, 1);
    return mipmap;
  }

  // Converts a mean vector (a r, a) to a Gaussian, as for a rough normal's point.
  static glm::vec4 as_gaussian(const glm::vec4& lobe) {
    return lobe.w * glm::vec4(rough_point(glm::vec3(lobe) / lobe.w), 1.0f);
  }

  const TemporaryFolder folder_;
};

const MaterialCase kCases[] = {{StorageEncoding::kSnorm16, false, true, 0},
                               {StorageEncoding::kSnorm16, true, false, 1},
                               {StorageEncoding::kHalf, true, true, 4},
                               {StorageEncoding::kFloat, false, true, 3},
                               {StorageEncoding::kSnorm16, true, true, 2, Representation::kGmm},
                               {StorageEncoding::kHalf, false, true, 0, Representation::kGmm},
                               {StorageEncoding::kFloat, false, true, 3, Representation::kGmm}};

// Returns only the cases that a test runs, so that no test is skipped.
template <typename Wanted>
std::vector<MaterialCase> cases_where(const Wanted& wanted) {
  std::vector<MaterialCase> cases;
  std::copy_if(std::begin(kCases), std::end(kCases), std::back_inserter(cases), wanted);
  return cases;
}

bool has_rough_lobes(const MaterialCase& c) { return c.has_roughness && c.lobes == Representation::kMovmf; }
bool has_rough_gaussians(const MaterialCase& c) { return c.has_roughness && c.lobes == Representation::kGmm; }
bool has_averages(const MaterialCase& c) { return c.encoding != StorageEncoding::kSnorm16; }
bool has_weights(const MaterialCase& c) { return c.weight_count > 0; }

class RoughLobesTest : public MaterialFileTest {};
class RoughGaussiansTest : public MaterialFileTest {};
class AveragesFileTest : public MaterialFileTest {};  // harmonics and moments, which have no snorm encoding
class WeightsFileTest : public MaterialFileTest {};

INSTANTIATE_TEST_SUITE_P(Files, MaterialFileTest, ::testing::ValuesIn(kCases));
INSTANTIATE_TEST_SUITE_P(Files, RoughLobesTest, ::testing::ValuesIn(cases_where(has_rough_lobes)));
INSTANTIATE_TEST_SUITE_P(Files, RoughGaussiansTest, ::testing::ValuesIn(cases_where(has_rough_gaussians)));
INSTANTIATE_TEST_SUITE_P(Files, AveragesFileTest, ::testing::ValuesIn(cases_where(has_averages)));
INSTANTIATE_TEST_SUITE_P(Files, WeightsFileTest, ::testing::ValuesIn(cases_where(has_weights)));

TEST_P(MaterialFileTest, LobesComeBackAsTheyWere) {
  const MovmfMipmap mipmap = lobes();
  const std::string path = folder_ / "a.exr";
  write_movmf_mipmap(path, mipmap, {.is_checked = false});
  const MovmfMipmap found = read_movmf_mipmap(path);
  testing::expect_same_bits(found, mipmap);
  EXPECT_EQ(found.header.weight_count, mipmap.header.weight_count);
  EXPECT_EQ(found.header.has_roughness, mipmap.header.has_roughness);
  EXPECT_EQ(found.header.mean_cosine, mipmap.header.mean_cosine);
  for (std::size_t l = 0; l < mipmap.levels.size(); ++l)
    EXPECT_EQ(found.levels[l].weights, mipmap.levels[l].weights) << l;
  EXPECT_EQ(found.header.provenance.content_hash, movmf_content_hash(mipmap, 2));
  EXPECT_EQ(failed(path), std::set<std::string>{});
  EXPECT_EQ(read_baked_header(path).format_version(), GetParam().lobes == Representation::kGmm ? 2 : 4);
  // A changed length in the finest level, or a changed weight, changes the checksum.
  MovmfMipmap other = mipmap;
  if (mipmap.header.weight_count > 0) other.levels[2].weights[1][0] += 0.5f;
  else other.levels[0].lobes = found.levels[0].lobes, other.levels[1].lobes[0][3] *= 0.5f;
  EXPECT_NE(movmf_content_hash(other, 2), found.header.provenance.content_hash);
}

TEST_P(RoughLobesTest, FinestNormalsKeepTheirLengths) {
  std::mt19937 random(3);
  MovmfFinest rows = testing::random_finest(random, 64, 8, 2, false);
  rows.has_roughness = true;
  std::vector<glm::vec3> exact;
  for (glm::vec3& n : rows.normals)
    exact.push_back(n *= 1.0f - 0.5f * static_cast<float>(std::pow(uniform(random), 4.0)));
  quantize_movmf(rows, GetParam().encoding, 2);
  const double step = GetParam().encoding == StorageEncoding::kHalf ? 1.0 / 2048.0 : 1.0 / 32767.0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_NEAR(glm::length(glm::dvec3(rows.normals[i])), glm::length(glm::dvec3(exact[i])), step);
    EXPECT_LT(glm::length(rows.normals[i] - exact[i]), 2.0 * step);
  }
}

// Points of the plane keep the scatter of their facets, from which the length of the normal can be computed again.
TEST_P(RoughGaussiansTest, FinestPointsKeepWhatTheyScatter) {
  std::mt19937 random(3);
  MovmfFinest rows = testing::random_finest(random, 64, 8, 2, false);
  rows.has_roughness = true;
  rows.representation = Representation::kGmm;
  std::vector<glm::vec3> exact, lengths;
  for (glm::vec3& n : rows.normals) {
    lengths.push_back(n *= 1.0f - 0.5f * static_cast<float>(std::pow(uniform(random), 4.0)));
    exact.push_back(n = rough_point(n));
    EXPECT_LE(n.z, 1.0f);
  }
  quantize_movmf(rows, GetParam().encoding, 2);
  const float step = GetParam().encoding == StorageEncoding::kHalf ? 1.0f / 1024.0f : 1.5f / 32767.0f;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const glm::vec3 difference = glm::abs(rows.normals[i] - exact[i]);
    EXPECT_LT(difference.x, step);
    EXPECT_LT(difference.y, step);
    const auto scatter = [](const glm::vec3& p) { return p.z - p.x * p.x - p.y * p.y; };
    EXPECT_NEAR(scatter(rows.normals[i]), scatter(exact[i]), 2.0f * step);
    EXPECT_LE(rows.normals[i].z, 1.0f);
    // Compares only normals that were not clamped at the rim.
    const glm::vec3 back = shortened_normal(exact[i]);
    const bool is_whole = exact[i].z < 0.999f;
    EXPECT_TRUE(!is_whole || glm::length(back - lengths[i]) < 2e-3f) << i;
  }
}

TEST_P(AveragesFileTest, HarmonicsComeBackAsTheyWere) {
  const MaterialCase& c = GetParam();
  ShMipmap mipmap;
  mipmap.header = full_header(lobes());
  mipmap.header.representation = Representation::kSh;
  mipmap.order = 1;
  mipmap.levels = empty_sh_levels(19, 13);
  std::mt19937 random(5);
  for (ShLevel& level : mipmap.levels) {
    level.parts.resize(1);
    for (int i = 0; i < level.width * level.height; ++i) {
      level.parts[0].emplace_back(kShNormalFactor * glm::vec3(0.2f, 0.6f, 0.1f), 0.0f);
      if (c.has_colours) level.colours.emplace_back(uniform(random));
      for (int k = 0; k < c.weight_count; ++k) level.weights.push_back(static_cast<float>(uniform(random)));
    }
    quantize_sh(level, c.encoding, 2);
  }
  const std::string path = folder_ / "s.exr";
  write_sh_mipmap(path, mipmap, {.is_checked = false});
  const ShMipmap found = read_sh_mipmap(path);
  EXPECT_EQ(found.header.weight_count, c.weight_count);
  EXPECT_EQ(found.header.has_roughness, c.has_roughness);
  for (std::size_t l = 0; l < mipmap.levels.size(); ++l) {
    EXPECT_EQ(found.levels[l].parts, mipmap.levels[l].parts) << l;
    EXPECT_EQ(found.levels[l].weights, mipmap.levels[l].weights) << l;
    EXPECT_EQ(found.levels[l].colours, mipmap.levels[l].colours) << l;
  }
  EXPECT_EQ(failed(path), c.has_roughness ? std::set<std::string>{} : std::set<std::string>{"level 0"});
  EXPECT_EQ(read_baked_header(path).format_version(), 2);
  mipmap.levels[0].parts[0][7] *= 0.5f;  // below the length of the roughest lobe
  write_sh_mipmap(path, mipmap, {.is_checked = false});
  EXPECT_EQ(failed(path), std::set<std::string>{"level 0"});
  if (c.weight_count == 0) return;
  mipmap.levels[1].weights[3] = 1.5f;
  write_sh_mipmap(path, mipmap, {.is_checked = false});
  EXPECT_EQ(failed(path), (std::set<std::string>{"level 0", "weights"}));
}

TEST_P(AveragesFileTest, MomentsComeBackAsTheyWere) {
  const MaterialCase& c = GetParam();
  MomentMipmap mipmap;
  mipmap.header = full_header(lobes());
  mipmap.header.representation = Representation::kMoments;
  mipmap.levels = empty_moment_levels(19, 13);
  std::mt19937 random(4);
  for (MomentLevel& level : mipmap.levels) {
    for (int i = 0; i < level.width * level.height; ++i) {
      const float s = static_cast<float>(uniform(random));
      level.slopes.push_back({kNoHeight, s, 0.0f, s * s + 0.1f, 0.1f, 0.0f});
      level.normals.emplace_back(0.3f, 0.1f, 0.5f);
      if (c.has_colours) level.colours.emplace_back(s);
      for (int k = 0; k < c.weight_count; ++k) level.weights.push_back(static_cast<float>(uniform(random)));
    }
    quantize_moments(level, c.encoding, 2);
  }
  const std::string path = folder_ / "m.exr";
  write_moment_mipmap(path, mipmap, {.is_checked = false});
  const MomentMipmap found = read_moment_mipmap(path);
  EXPECT_EQ(found.header.weight_count, c.weight_count);
  EXPECT_EQ(found.header.has_roughness, c.has_roughness);
  for (std::size_t l = 0; l < mipmap.levels.size(); ++l) {
    EXPECT_EQ(found.levels[l].weights, mipmap.levels[l].weights) << l;
    EXPECT_EQ(found.levels[l].normals, mipmap.levels[l].normals) << l;
    EXPECT_EQ(found.levels[l].colours, mipmap.levels[l].colours) << l;
  }
  EXPECT_EQ(failed(path), std::set<std::string>{});
  EXPECT_EQ(read_baked_header(path).format_version(), 2);
  if (c.weight_count == 0) return;
  mipmap.levels[1].weights[3] = 1.5f;
  write_moment_mipmap(path, mipmap, {.is_checked = false});
  EXPECT_EQ(failed(path), std::set<std::string>{"weights"});
}

TEST_P(WeightsFileTest, VerifyNamesTheWeightThatCannotBe) {
  MovmfMipmap mipmap = lobes();
  const std::string path = folder_ / "a.exr";
  const auto count = static_cast<std::size_t>(mipmap.header.weight_count);
  mipmap.levels[1].weights[2][5 * count] = -0.25f;
  write_movmf_mipmap(path, mipmap, {.is_checked = false});
  EXPECT_EQ(failed(path), std::set<std::string>{"weights"});
  mipmap.levels[1].weights[2][5 * count] = 2.0f;
  write_movmf_mipmap(path, mipmap, {.is_checked = false});
  EXPECT_EQ(failed(path), std::set<std::string>{"weights"});
  mipmap.levels[1].weights[2][5 * count] = NAN;
  write_movmf_mipmap(path, mipmap, {.is_checked = false});
  EXPECT_EQ(failed(path), std::set<std::string>{"finite"});
}

// If the list of cases were empty, there would be no tests, so no test could fail.
TEST(MaterialFile, EveryTestHasCases) {
  EXPECT_EQ(cases_where(has_rough_lobes).size(), 3u);
  EXPECT_EQ(cases_where(has_rough_gaussians).size(), 3u);
  EXPECT_EQ(cases_where(has_averages).size(), 4u);
  EXPECT_EQ(cases_where(has_weights).size(), 5u);
}

TEST(MaterialFile, WithoutMaterialsTheVersionIsTheOld) {
  MovmfMipmap mipmap = testing::random_mipmap(8, 8, 2, true, StorageEncoding::kHalf, 1);
  EXPECT_EQ(full_header(mipmap).format_version(), 3);
  mipmap.header.weight_count = 1;
  EXPECT_EQ(full_header(mipmap).format_version(), 4);
}

}  // namespace
}  // namespace multum
