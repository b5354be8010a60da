// SPDX-License-Identifier: Apache-2.0
// Tests the error of a region that was baked again. Only the texels of the region count. The sides of the region are
// half as long as the sides of the map, so the region's texels in all levels form a mipmap.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <map>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/bake/bake_file.h"
#include "host/formats/asset/lobes/movmf_reader.h"
#include "host/formats/image/files/png_writer.h"
#include "host/foundation/base/split_mix.h"
#include "tests/fixtures/test_maps.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

constexpr int kSide = 256, kRegionSide = 64, kRegionX = 128, kRegionY = 64;

// Writes a map of waves, with noise that gets steeper to the right. In the edited map, the region contains a dome.
NormalMap write_map(const std::string& path, bool edited) {
  SplitMix64 random(1);
  const NormalMap map = testing::make_map(kSide, kSide, [&](int x, int y) {
    const double steep = 0.2 + 0.8 * x / kSide;
    const double noise_x = steep * (random.uniform() - 0.5), noise_y = steep * (random.uniform() - 0.5);
    const double dx = (x - kRegionX - 31.5) / 28.0, dy = (y - kRegionY - 31.5) / 28.0, squared = dx * dx + dy * dy;
    if (edited && squared < 0.9) return glm::dvec3(dx, dy, std::sqrt(1.0 - squared));
    return glm::normalize(glm::dvec3(0.5 * std::sin(0.3 * x) + noise_x, 0.3 * std::cos(0.2 * y) + noise_y, 1.0));
  });
  write_png16(path, kSide, kSide, testing::normal_codes(map), "Linear");
  return map;
}

template <typename Value>
std::vector<Value> cut(const std::vector<Value>& plane, int level) {
  const int size = kRegionSide >> level, width = kSide >> level, x0 = kRegionX >> level, y0 = kRegionY >> level;
  std::vector<Value> part;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) part.push_back(plane[static_cast<std::size_t>((y0 + y) * width + x0 + x)]);
  return part;
}

// Returns the error of the region for each BRDF. Each error is a mean over levels and points.
std::map<std::string, double> region_errors(Device& device, const std::string& file, const NormalMap& map) {
  const MovmfMipmap whole = read_movmf_mipmap(file);
  MovmfMipmap part;
  part.header.encoding = whole.header.encoding;
  for (int l = 0; kRegionSide >> l > 0; ++l) {
    MovmfLevel level{kRegionSide >> l, kRegionSide >> l, {}, {}};
    for (const auto& lobe : whole.levels[static_cast<std::size_t>(l)].lobes) level.lobes.push_back(cut(lobe, l));
    part.levels.push_back(std::move(level));
  }
  NormalMap reference;
  reference.width = reference.height = kRegionSide;
  reference.x = cut(map.x, 0);
  reference.y = cut(map.y, 0);
  reference.z = cut(map.z, 0);
  AccuracySettings settings;
  settings.samples_per_level = 0;
  std::map<std::string, double> sums;
  std::map<std::string, int> counts;
  for (const AccuracyRow& row : measure_accuracy(device, part, reference, nullptr, settings, nullptr)) {
    if (row.level == 0) continue;
    sums[row.brdf.text()] += row.error;
    ++counts[row.brdf.text()];
  }
  for (auto& [brdf, sum] : sums) sum /= counts[brdf];
  return sums;
}

TEST(RegionErrorTest, IsAtMostAHundredthAboveAWholeBakes) {
  const testing::TemporaryFolder folder;
  write_map(folder / "map.png", false);
  const NormalMap edited = write_map(folder / "edited.png", true);
  Device device = Device::open("");
  BakeJob job;
  job.reading.green = GreenAxis::kUp;
  job.measure = false;
  const auto bake = [&](const std::string& map, const std::string& output) {
    job.input = folder / map;
    job.output = folder / output;
    bake_file(job, nullptr, device, nullptr);
    return job.output;
  };
  const std::string old = bake("map.png", "old.ndf.exr"), whole = bake("edited.png", "whole.ndf.exr");
  job.region = MapRegion{kRegionX, kRegionY, kRegionSide, kRegionSide};
  job.onto = old;
  const std::string again = bake("edited.png", "again.ndf.exr");
  const auto before = region_errors(device, old, edited), after = region_errors(device, again, edited),
             wanted = region_errors(device, whole, edited);
  for (const auto& [brdf, error] : wanted) {
    EXPECT_LT(after.at(brdf), 1.01 * error + 1e-5) << brdf;
    EXPECT_GT(before.at(brdf), 1.5 * error) << brdf << ": the edit is seen";
  }
  EXPECT_EQ(job.hashes->read_count(), 2) << "edited.png was baked twice and hashed once";
  write_map(folder / "edited.png", false);
  testing::expect_error(ErrorCode::kInput, {"edited.png", "changed while it was being read"},
                        [&] { bake("edited.png", "changed.ndf.exr"); });
}

}  // namespace
}  // namespace multum
