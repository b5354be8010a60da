// SPDX-License-Identifier: Apache-2.0
// Tests the picture error that texture storage adds. Lossless storage adds no error. Coarser codes add more error, and
// smooth metal gets more error than dull stone.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "host/delivery/export/accuracy/storage_error.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

constexpr int kMapSide = 64;

std::uint8_t code(double share) { return static_cast<std::uint8_t>(std::lround(255.0 * share)); }

class StorageErrorTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::testing::TempDir() + "storage_error_" + std::to_string(getpid());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Makes bumps whose normals are multiples of `step` codes.
  LevelFile bumps(const char* name, int step) const {
    return filled(name, [step](SplitMix64& random) {
      const glm::dvec3 n = glm::normalize(glm::dvec3(random.uniform() - 0.5, random.uniform() - 0.5, 1.5));
      const auto stepped = [step](double v) {
        return static_cast<std::uint8_t>(std::min<long>(255, std::lround(255.0 * (0.5 + 0.5 * v) / step) * step));
      };
      return std::array<std::uint8_t, 3>{stepped(n.x), stepped(n.y), stepped(n.z)};
    });
  }
  LevelFile surface(const char* name, double roughness, double metalness) const {
    return filled(name, [=](SplitMix64&) {
      return std::array<std::uint8_t, 3>{255, code(roughness), code(metalness)};
    });
  }

 private:
  template <typename Texel>
  LevelFile filled(const char* name, const Texel& texel) const {
    LevelFile file(folder_, name, kMapSide, kMapSide);
    SplitMix64 random(7);
    for (int level = 0; level < file.level_count(); ++level) {
      const int side = mip_level_size(kMapSide, level);
      std::vector<std::uint8_t> texels;
      for (int i = 0; i < side * side; ++i) {
        const auto rgb = texel(random);
        texels.insert(texels.end(), {rgb[0], rgb[1], rgb[2], 255});
      }
      file.write_rows(level, 0, texels);
    }
    return file;
  }

  std::string folder_;
};

TEST_F(StorageErrorTest, GrowsWithWhatIsLost) {
  const LevelFile normal = bumps("exact", 1), fine = bumps("fine", 4), coarse = bumps("coarse", 16);
  const LevelFile metal = surface("metal", 0.3, 1.0), stone = surface("stone", 0.9, 0.0);
  const MaterialLevels exact{&normal, &metal};
  EXPECT_EQ(storage_error(exact, exact).error, 0.0);
  const double by_fine = storage_error(exact, {&fine, &metal}).error;
  const double by_coarse = storage_error(exact, {&coarse, &metal}).error;
  EXPECT_GT(by_fine, 0.0);
  EXPECT_GT(by_coarse, 3.0 * by_fine);
  EXPECT_GT(by_coarse, 0.01);
  // Stone scatters light so broadly that small changes of a normal hardly matter.
  EXPECT_LT(storage_error({&normal, &stone}, {&coarse, &stone}).error, 0.3 * by_coarse);
}

TEST_F(StorageErrorTest, SeesRoughness) {
  const LevelFile normal = bumps("normal", 1), metal = surface("metal", 0.30, 1.0), other = surface("other", 0.33, 1.0);
  EXPECT_GT(storage_error({&normal, &metal}, {&normal, &other}).error, 0.01);
  // Without a roughness texture, the surface has the same roughness everywhere.
  const MaterialLevels plain{&normal, nullptr, 0.3, 1.0}, rougher{&normal, nullptr, 0.33, 1.0};
  EXPECT_NEAR(storage_error(plain, rougher).error, storage_error({&normal, &metal}, {&normal, &other}).error, 0.01);
  const LobeSurface mean = mean_surface({&normal, &metal});
  EXPECT_NEAR(mean.roughness, 0.3, 0.01);
  EXPECT_NEAR(mean.metalness, 1.0, 1e-6);
}

TEST(LobeStorageErrorTest, DividesByTheSumOfAmplitudes) {
  const std::vector<glm::vec4> one(16, glm::vec4(0.3f, 0.0f, 0.5f, 0.6f)), two(16, glm::vec4(-0.1f, 0.1f, 0.3f, 0.4f));
  const auto scaled = [](std::vector<glm::vec4> lobes, float factor) {
    for (glm::vec4& lobe : lobes) lobe *= factor;
    return lobes;
  };
  const std::vector<std::vector<glm::vec4>> exact = {one, two}, brighter = {scaled(one, 1.1f), scaled(two, 1.1f)};
  const std::vector<std::vector<glm::vec4>> other = {scaled(one, 1.2f), two};
  const std::vector<LobeLevel> levels = {{4, 4, &exact}};
  const LobeSurface surface{0.4, 1.0};
  EXPECT_LT(lobe_storage_error(levels, {{4, 4, &brighter}}, surface).error, 1e-6);
  EXPECT_GT(lobe_storage_error(levels, {{4, 4, &other}}, surface).error, 1e-3);
}

}  // namespace
}  // namespace multum
