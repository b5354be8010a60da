// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/mapping/parameter_grid.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

bool is_same_place(const AnimationSample& a, const AnimationSample& b) {
  return a.camera == b.camera && a.object_to_world == b.object_to_world;
}

// Returns the distance between neighbouring samples along a parameter.
std::size_t stride_of(const std::vector<AnimationParameter>& parameters, std::size_t d) {
  std::size_t stride = 1;
  for (std::size_t below = d + 1; below < parameters.size(); ++below)
    stride *= static_cast<std::size_t>(parameters[below].count);
  return stride;
}

bool moves_anything(const AnimationJob& job, std::size_t d) {
  const std::size_t stride = stride_of(job.parameters, d);
  for (std::size_t s = 0; s < job.samples.size(); ++s)
    if (job.samples[s].at[d] > 0 && !is_same_place(job.samples[s], job.samples[s - stride])) return true;
  return false;
}

int point_count(const std::vector<ParameterRange>& ranges, const std::vector<std::size_t>& dimensions) {
  int count = 1;
  for (const std::size_t d : dimensions) count *= ranges[d].count;
  return count;
}

// Sets the indices of the point with this `number`. The last dimension changes fastest.
void count_up(const std::vector<ParameterRange>& ranges, const std::vector<std::size_t>& dimensions, int number,
              std::vector<int>& at) {
  for (std::size_t i = dimensions.size(); i-- > 0;) {
    const ParameterRange& range = ranges[dimensions[i]];
    at[dimensions[i]] = range.first + number % range.count;
    number /= range.count;
  }
}

// Visits the same points in an order in which each point is a neighbour of the previous one. A dimension runs backwards
// if the sum of the indices of the slower dimensions, each counted from its first index, is odd.
void plough(const std::vector<ParameterRange>& ranges, const std::vector<std::size_t>& dimensions, int number,
            std::vector<int>& at) {
  count_up(ranges, dimensions, number, at);
  int steps = 0;
  for (const std::size_t d : dimensions) {
    const ParameterRange& range = ranges[d];
    if (steps % 2 == 1) at[d] = 2 * range.first + range.count - 1 - at[d];
    steps += at[d] - range.first;
  }
}

}  // namespace

ParameterGrid::ParameterGrid(const AnimationJob& job) : parameters_(job.parameters) {
  std::size_t count = 1;
  for (const AnimationParameter& parameter : parameters_) count *= static_cast<std::size_t>(parameter.count);
  MULTUM_CHECK(job.samples.size() == count);
  find_blocks(job);
  find_poses(job);
}

void ParameterGrid::find_blocks(const AnimationJob& job) {
  for (std::size_t d = 0; d < parameters_.size(); ++d) {
    const AnimationParameter& parameter = parameters_[d];
    const bool has_blocks = parameter.block > 0 && parameter.block < parameter.count && moves_anything(job, d);
    block_sizes_.push_back(has_blocks ? parameter.block : parameter.count);
    block_counts_.push_back((parameter.count + block_sizes_[d] - 1) / block_sizes_[d]);
    block_count_ *= block_counts_[d];
  }
  for (const AnimationSample& sample : job.samples) {
    int block = 0;
    for (std::size_t d = 0; d < parameters_.size(); ++d)
      block = block * block_counts_[d] + sample.at[d] / block_sizes_[d];
    block_of_sample_.push_back(block);
  }
}

void ParameterGrid::find_poses(const AnimationJob& job) {
  for (std::size_t s = 0; s < job.samples.size(); ++s) {
    const AnimationSample& sample = job.samples[s];
    auto pose = std::find_if(poses_.begin(), poses_.end(), [&](const AnimationPose& known) {
      return known.block == block_of_sample_[s] && known.camera == sample.camera &&
             known.object_to_world == sample.object_to_world;
    });
    if (pose == poses_.end())
      pose = poses_.insert(poses_.end(), {sample.name, sample.camera, block_of_sample_[s], sample.object_to_world, {}});
    pose->samples.push_back(static_cast<int>(s));
    pose_of_sample_.push_back(static_cast<int>(pose - poses_.begin()));
  }
}

std::vector<ParameterRange> ParameterGrid::ranges(int block) const {
  std::vector<ParameterRange> ranges(parameters_.size());
  for (std::size_t d = parameters_.size(); d-- > 0;) {
    const int first = block % block_counts_[d] * block_sizes_[d];
    ranges[d] = {first, std::min(block_sizes_[d], parameters_[d].count - first)};
    block /= block_counts_[d];
  }
  return ranges;
}

std::string ParameterGrid::point_name(const std::vector<bool>& is_fixed, const std::vector<ParameterRange>& ranges,
                                      const std::vector<int>& at) const {
  std::vector<std::string> parts;
  for (std::size_t d = 0; d < parameters_.size(); ++d) {
    if (is_fixed[d]) parts.push_back(fmt::format("{}{:02}", parameters_[d].name, at[d]));
    else if (ranges[d].count < parameters_[d].count)
      parts.push_back(
          fmt::format("{}{:02}-{:02}", parameters_[d].name, ranges[d].first, ranges[d].first + ranges[d].count - 1));
  }
  return parts.empty() ? "all" : fmt::format("{}", fmt::join(parts, "_"));
}

std::string ParameterGrid::block_name(int block) const {
  return point_name(std::vector<bool>(parameters_.size(), false), ranges(block), {});
}

int ParameterGrid::sample_at(const std::vector<int>& at) const {
  int sample = 0;
  for (std::size_t d = 0; d < at.size(); ++d) sample = sample * parameters_[d].count + at[d];
  return sample;
}

std::vector<ParameterPoint> ParameterGrid::points(const AnimationLayer& layer) const {
  std::vector<bool> is_fixed(parameters_.size());  // true if the layer depends on this parameter, so that a point has
                                                   // only one index along it
  for (std::size_t d = 0; d < parameters_.size(); ++d)
    is_fixed[d] =
        std::find(layer.depends_on.begin(), layer.depends_on.end(), parameters_[d].name) != layer.depends_on.end();
  std::vector<std::size_t> fixed, free;
  for (const bool wants_views : {true, false})
    for (std::size_t d = 0; d < parameters_.size(); ++d)
      if (is_fixed[d] && parameters_[d].is_view == wants_views) fixed.push_back(d);
  for (std::size_t d = 0; d < parameters_.size(); ++d)
    if (!is_fixed[d]) free.push_back(d);

  std::vector<ParameterPoint> points;
  for (int block = 0; block < block_count_; ++block) {
    const std::vector<ParameterRange> within = ranges(block);
    for (int number = 0; number < point_count(within, fixed); ++number) {
      std::vector<int> at(parameters_.size(), 0);
      plough(within, fixed, number, at);
      ParameterPoint point{point_name(is_fixed, within, at), block, {}};
      for (int s = 0; s < point_count(within, free); ++s) {
        count_up(within, free, s, at);
        point.samples.push_back(sample_at(at));
      }
      points.push_back(std::move(point));
    }
  }
  return points;
}

}  // namespace multum
