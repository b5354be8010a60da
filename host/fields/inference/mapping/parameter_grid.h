// SPDX-License-Identifier: Apache-2.0
// Groups the samples of the parameter grid into blocks, poses and points. The samples of a block share texture
// coordinates (Hakura et al. 2000, section 3.4), the samples of a pose share filter matrices, and the samples of a
// layer's point share one texture.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

#include "host/fields/inference/job/animation_job.h"

namespace multum {

/// A camera and the places of objects in one block. The samples of a pose share their filter matrices under any light.
struct AnimationPose {
  std::string name;  // name of the pose's first sample
  int camera = 0;
  int block = 0;
  std::map<std::string, glm::dmat4> object_to_world;
  std::vector<int> samples;
};

/// The samples that one texture of a layer serves. These are the samples of a block that agree in the layer's
/// parameters.
struct ParameterPoint {
  std::string name;  // "light03", "view00-07", "all"
  int block = 0;
  std::vector<int> samples;  // indices of the job's samples
};

/// Neighbouring indices along a parameter.
struct ParameterRange {
  int first, count;
};

class ParameterGrid {
 public:
  /// Keeps no reference to the job. Samples are in the order of the grid, in which the last parameter changes fastest.
  explicit ParameterGrid(const AnimationJob& job);

  /// Returns the number of blocks of neighbouring samples. A block has AnimationParameter::block samples along each
  /// parameter. Only parameters that move the camera or an object divide the grid into blocks.
  int block_count() const { return block_count_; }
  /// Returns "view00-07", or "all" if there is one block.
  std::string block_name(int block) const;
  int block_of(int sample) const { return block_of_sample_[static_cast<std::size_t>(sample)]; }
  const std::vector<AnimationPose>& poses() const { return poses_; }
  int pose_of(int sample) const { return pose_of_sample_[static_cast<std::size_t>(sample)]; }

  /// Returns all points of a layer, block by block. Within a block, each point is a neighbour of the previous one
  /// (boustrophedon order). View parameters change slowest, so that successive points share filter matrices as long as
  /// possible.
  std::vector<ParameterPoint> points(const AnimationLayer& layer) const;

 private:
  void find_blocks(const AnimationJob& job);
  void find_poses(const AnimationJob& job);
  std::vector<ParameterRange> ranges(int block) const;  // ranges along all parameters
  std::string point_name(const std::vector<bool>& is_fixed, const std::vector<ParameterRange>& ranges,
                         const std::vector<int>& at) const;
  int sample_at(const std::vector<int>& at) const;

  std::vector<AnimationParameter> parameters_;
  std::vector<int> block_sizes_;  // block size along each parameter, or its number of samples if it has no blocks
  std::vector<int> block_counts_;
  int block_count_ = 1;
  std::vector<int> block_of_sample_;
  std::vector<AnimationPose> poses_;
  std::vector<int> pose_of_sample_;
};

}  // namespace multum
