// SPDX-License-Identifier: Apache-2.0
// Groups the samples of the grid of parameters: the blocks that share texture coordinates (Hakura et al. 2000, section
// 3.4), the poses that share filter matrices, and the points of a layer, each with one texture.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

#include "host/fields/inference/job/animation_job.h"

namespace multum {

/// A camera and where the objects are, in one block: its samples share their filter matrices, whatever the light does.
struct AnimationPose {
  std::string name;  // of its first sample
  int camera = 0;
  int block = 0;
  std::map<std::string, glm::dmat4> object_to_world;
  std::vector<int> samples;
};

/// What one texture of a layer serves: the samples of a block that agree in what the layer depends on.
struct ParameterPoint {
  std::string name;  // "light03", "view00-07", "all"
  int block = 0;
  std::vector<int> samples;  // of the job
};

/// Neighbouring indices along a parameter.
struct ParameterRange {
  int first, count;
};

class ParameterGrid {
 public:
  /// Keeps no reference to the job. Its samples are in the order of the grid, the last parameter fastest.
  explicit ParameterGrid(const AnimationJob& job);

  /// Blocks of neighbouring samples, AnimationParameter::block along each parameter. Only parameters that move the
  /// camera or an object count: what the others change is not where things are.
  int block_count() const { return block_count_; }
  /// "view00-07"; "all" where there is one.
  std::string block_name(int block) const;
  int block_of(int sample) const { return block_of_sample_[static_cast<std::size_t>(sample)]; }
  const std::vector<AnimationPose>& poses() const { return poses_; }
  int pose_of(int sample) const { return pose_of_sample_[static_cast<std::size_t>(sample)]; }

  /// All points of a layer, block by block, and in a block each a neighbour of the one before: as an ox ploughs,
  /// parameters of views slowest, so that neighbours share their filter matrices as long as they can.
  std::vector<ParameterPoint> points(const AnimationLayer& layer) const;

 private:
  void find_blocks(const AnimationJob& job);
  void find_poses(const AnimationJob& job);
  std::vector<ParameterRange> ranges(int block) const;  // of each parameter
  std::string point_name(const std::vector<bool>& is_fixed, const std::vector<ParameterRange>& ranges,
                         const std::vector<int>& at) const;
  int sample_at(const std::vector<int>& at) const;

  std::vector<AnimationParameter> parameters_;
  std::vector<int> block_sizes_;  // along each parameter: its count where there are no blocks
  std::vector<int> block_counts_;
  int block_count_ = 1;
  std::vector<int> block_of_sample_;
  std::vector<AnimationPose> poses_;
  std::vector<int> pose_of_sample_;
};

}  // namespace multum
