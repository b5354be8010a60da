// SPDX-License-Identifier: Apache-2.0
// Tests that copies of a map, fitted together from different starts (make_copies()), get the same lobes as a map that
// is fitted alone.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <random>

#include "host/bakes/movmf/movmf_fit.h"
#include "host/formats/image/normals/normal_map.h"
#include "tests/kernels/em_harness.h"

namespace multum::testing {
namespace {

constexpr int kSide = 64, kFinest = 2;

// Keeps the rows of each level in order.
class LobeSink : public MovmfSink {
 public:
  void add_level(int level, int, MovmfLevel rows) override {
    std::vector<glm::vec4>& to = levels_[level];
    // Orders the lobes by row, then by lobe, so that copies follow each other.
    const auto width = static_cast<std::ptrdiff_t>(rows.width);
    for (std::ptrdiff_t y = 0; y < rows.height; ++y)
      for (const auto& lobe : rows.lobes) to.insert(to.end(), lobe.begin() + y * width, lobe.begin() + (y + 1) * width);
  }
  void add_finest(int, MovmfFinest) override {}
  const std::vector<glm::vec4>& level(int number) const { return levels_.at(number); }

 private:
  std::map<int, std::vector<glm::vec4>> levels_;
};

NormalMap random_map(int copies) {
  NormalMap map;
  map.width = kSide;
  map.height = kSide * copies;
  std::mt19937 random(5);
  std::normal_distribution<double> slope(0.0, 0.4);
  for (int i = 0; i < kSide * kSide; ++i) {
    const glm::vec3 n(glm::normalize(glm::dvec3(slope(random), slope(random), 1.0)));
    map.x.push_back(n.x);
    map.y.push_back(n.y);
    map.z.push_back(n.z);
  }
  for (std::vector<float>* plane : {&map.x, &map.y, &map.z}) {
    const std::vector<float> one = *plane;
    for (int i = 1; i < copies; ++i) plane->insert(plane->end(), one.begin(), one.end());
  }
  return map;
}

LobeSink fit_from(const std::vector<std::vector<MultumVmfLobe>>& starts, const MovmfSettings& settings) {
  const int count = static_cast<int>(starts.size());
  const NormalMap one = random_map(1), copies = random_map(count);
  const PlaneStore one_plane = planes_of(one), planes = planes_of(copies);
  const MapInputs map{&planes};
  MipSchedule schedule = make_mip_schedule(one_plane, settings);
  if (count > 1) make_copies(schedule, count);
  BakePlan plan = make_bake_plan(schedule, settings, map, test_device().shape());
  for (const LevelSchedule& level : schedule.levels) plan.levels.at(level.level).band_rows = level.fit.height;
  std::vector<MultumVmfLobe> lobes;
  for (const std::vector<MultumVmfLobe>& start : starts) lobes.insert(lobes.end(), start.begin(), start.end());
  LobeSink sink;
  RowOrigin rows(&sink, map.spill);
  FitReport report;
  MovmfFit fit(
      test_device(), map, settings, schedule, plan, rows, [&] { return lobes; }, report, nullptr);
  for (const LevelSchedule& level : schedule.levels)
    if (level.level >= kFinest) fit.fit(level);
  return sink;
}

TEST(MovmfCopiesTest, CopiesAreFittedAsIfTheyWereAlone) {
  std::vector<std::vector<MultumVmfLobe>> starts;
  for (const float tilt : {0.2f, 0.35f, 0.5f})
    starts.push_back({{tilt, 0.0f, 0.8f, 0.5f}, {-tilt, 0.1f, 0.8f, 0.3f}, {0.0f, -tilt, 0.7f, 0.2f}});
  for (const bool is_periodic : {true, false}) {
    SCOPED_TRACE(is_periodic);
    MovmfSettings settings;
    settings.lobe_count = 3;
    settings.periodic_x = settings.periodic_y = is_periodic;
    const LobeSink together = fit_from(starts, settings);
    for (std::size_t c = 0; c < starts.size(); ++c) {
      const LobeSink single = fit_from({starts[c]}, settings);
      for (int level = kFinest; level <= 6; ++level) {
        const std::vector<glm::vec4>& expected = single.level(level);
        ASSERT_EQ(together.level(level).size(), starts.size() * expected.size());
        const auto begin = together.level(level).begin() + static_cast<std::ptrdiff_t>(c * expected.size());
        EXPECT_TRUE(std::equal(expected.begin(), expected.end(), begin)) << "copy " << c << ", level " << level;
      }
    }
    EXPECT_NE(fit_from({starts[0]}, settings).level(4), fit_from({starts[2]}, settings).level(4));
  }
}

}  // namespace
}  // namespace multum::testing
