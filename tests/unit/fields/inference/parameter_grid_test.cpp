// SPDX-License-Identifier: Apache-2.0
// Tests the blocks, poses and points of parameter grids, with samples that are made in memory.
#include "host/fields/inference/mapping/parameter_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

namespace multum {
namespace {

using Samples = std::vector<int>;

// Each index of a parameter named "view..." has its own camera; each index of a parameter named "motion..." moves a
// thing.
AnimationJob job_of(const std::vector<AnimationParameter>& parameters) {
  AnimationJob job;
  job.parameters = parameters;
  int count = 1;
  for (const AnimationParameter& parameter : parameters) count *= parameter.count;
  for (int s = 0; s < count; ++s) {
    AnimationSample sample;
    sample.name = "s" + std::to_string(s);
    int rest = s;
    for (std::size_t d = parameters.size(); d-- > 0;) {
      const int at = rest % parameters[d].count;
      rest /= parameters[d].count;
      sample.at.insert(sample.at.begin(), at);
      if (parameters[d].is_view) sample.camera = sample.camera * 100 + at;
      if (parameters[d].name.starts_with("motion"))
        sample.object_to_world[parameters[d].name] = glm::dmat4(static_cast<double>(1 + at));
    }
    job.samples.push_back(sample);
  }
  return job;
}

AnimationLayer layer_of(const std::vector<std::string>& depends_on) { return {"layer", {""}, depends_on}; }

std::vector<std::string> names_of(const std::vector<ParameterPoint>& points) {
  std::vector<std::string> names;
  for (const ParameterPoint& point : points) names.push_back(point.name);
  return names;
}

TEST(ParameterGrid, WithoutBlocksAllShareOne) {
  const ParameterGrid grid(job_of({{"view", 3, true}, {"light", 2, false}}));
  EXPECT_EQ(grid.block_count(), 1);
  EXPECT_EQ(grid.block_name(0), "all");
  ASSERT_EQ(grid.poses().size(), 3u);
  EXPECT_EQ(grid.poses()[1].name, "s2");
  EXPECT_EQ(grid.poses()[1].samples, (Samples{2, 3})) << "the light moves nothing";
  EXPECT_EQ(grid.pose_of(5), 2);

  const std::vector<ParameterPoint> all = grid.points(layer_of({}));
  EXPECT_EQ(names_of(all), std::vector<std::string>{"all"});
  EXPECT_EQ(all[0].samples, (Samples{0, 1, 2, 3, 4, 5}));
  const std::vector<ParameterPoint> lights = grid.points(layer_of({"light"}));
  EXPECT_EQ(names_of(lights), (std::vector<std::string>{"light00", "light01"}));
  EXPECT_EQ(lights[1].samples, (Samples{1, 3, 5}));
  const std::vector<ParameterPoint> each = grid.points(layer_of({"light", "view"}));
  EXPECT_EQ(names_of(each), (std::vector<std::string>{"view00_light00", "view00_light01", "view01_light01",
                                                      "view01_light00", "view02_light00", "view02_light01"}));
  EXPECT_EQ(each[2].samples, Samples{3});
}

TEST(ParameterGrid, BlocksAreOfNeighboursAndTheLastMayBeShorter) {
  const ParameterGrid grid(job_of({{"view", 5, true, 2}, {"light", 2, false}}));
  EXPECT_EQ(grid.block_count(), 3);
  EXPECT_EQ(grid.block_name(1), "view02-03");
  EXPECT_EQ(grid.block_name(2), "view04-04");
  EXPECT_EQ(grid.block_of(3), 0);
  EXPECT_EQ(grid.block_of(4), 1);
  EXPECT_EQ(grid.block_of(9), 2);
  EXPECT_EQ(grid.poses().size(), 5u);
  EXPECT_EQ(grid.poses()[3].block, 1);

  // A layer that does not depend on the view has only one texture for each block of views.
  const std::vector<ParameterPoint> lights = grid.points(layer_of({"light"}));
  EXPECT_EQ(names_of(lights),
            (std::vector<std::string>{"view00-01_light00", "view00-01_light01", "view02-03_light00",
                                      "view02-03_light01", "view04-04_light00", "view04-04_light01"}));
  EXPECT_EQ(lights[3].samples, (Samples{5, 7}));
  EXPECT_EQ(lights[3].block, 1);
}

TEST(ParameterGrid, BlocksOfWhatMovesNothingDoNotCount) {
  const ParameterGrid grid(job_of({{"view", 2, true}, {"light", 6, false, 2}}));
  EXPECT_EQ(grid.block_count(), 1);
  EXPECT_EQ(names_of(grid.points(layer_of({"view"}))), (std::vector<std::string>{"view00", "view01"}));
}

TEST(ParameterGrid, APoseThatComesAgainInAnotherBlockIsAnother) {
  AnimationJob job = job_of({{"motion", 4, false, 2}});
  job.samples[3].object_to_world = job.samples[0].object_to_world;
  job.samples[1].object_to_world = job.samples[0].object_to_world;
  const ParameterGrid grid(job);
  ASSERT_EQ(grid.poses().size(), 3u);
  EXPECT_EQ(grid.pose_of(1), grid.pose_of(0));
  EXPECT_NE(grid.pose_of(3), grid.pose_of(0));
}

// Every sample belongs to exactly one point. Each point of a block differs from the previous one by one step along one
// parameter.
TEST(ParameterGrid, PointsAreWalkedByNeighboursAndMissNothing) {
  const std::vector<std::vector<AnimationParameter>> spaces = {
      {{"view", 3, true}, {"light", 2, false}, {"motion", 4, false}},
      {{"motion", 5, false, 3}, {"light", 3, false}, {"view", 4, true, 2}},
      {{"view", 7, true, 7}, {"view2", 2, true, 1}, {"light", 2, false, 1}, {"motion", 3, false, 2}}};
  for (const std::vector<AnimationParameter>& parameters : spaces) {
    const AnimationJob job = job_of(parameters);
    const ParameterGrid grid(job);
    for (unsigned chosen = 0; chosen < 1u << parameters.size(); ++chosen) {
      AnimationLayer layer = layer_of({});
      for (std::size_t d = 0; d < parameters.size(); ++d)
        if ((chosen >> d & 1u) != 0) layer.depends_on.push_back(parameters[d].name);
      SCOPED_TRACE(chosen);
      std::multiset<int> seen;
      std::set<std::string> names;
      const std::vector<ParameterPoint> points = grid.points(layer);
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_TRUE(names.insert(points[i].name).second) << points[i].name;
        seen.insert(points[i].samples.begin(), points[i].samples.end());
        EXPECT_TRUE(std::is_sorted(points[i].samples.begin(), points[i].samples.end()));
        for (const int s : points[i].samples) EXPECT_EQ(grid.block_of(s), points[i].block);
        if (i == 0 || points[i].block != points[i - 1].block) continue;
        int steps = 0;
        for (std::size_t d = 0; d < parameters.size(); ++d)
          steps += std::abs(job.samples[static_cast<std::size_t>(points[i].samples[0])].at[d] -
                            job.samples[static_cast<std::size_t>(points[i - 1].samples[0])].at[d]);
        EXPECT_EQ(steps, 1) << points[i - 1].name << " " << points[i].name;
      }
      EXPECT_EQ(seen.size(), job.samples.size());
      EXPECT_EQ(std::set<int>(seen.begin(), seen.end()).size(), job.samples.size());
    }
  }
}

}  // namespace
}  // namespace multum
