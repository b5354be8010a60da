// SPDX-License-Identifier: Apache-2.0
// What a job of texture inference refers to, as its stages need it: meshes, poses, what is seen where, and the objects'
// layers of each sample (Hakura et al. 2000, section 3.1). Pictures are read when asked for, not kept.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/asset/texture_mapping.h"
#include "host/bake/animation_job.h"
#include "host/bake/item_buffer.h"
#include "host/bake/layer_segmentation.h"
#include "host/mesh/object_mesh.h"

namespace multum {

/// A camera and where the objects are: samples of one pose share their filter matrices, whatever the light does.
struct AnimationPose {
  std::string name;  // of its first sample
  int camera = 0;
  std::map<std::string, glm::dmat4> object_to_world;
  std::vector<int> samples;
};

class AnimationField {
 public:
  /// Reads the geometry; checks one picture of every pose against its camera (camera_check.h) where there is a depth
  /// channel. Throws Error(kInput).
  explicit AnimationField(AnimationJob job);

  const AnimationJob& job() const { return job_; }
  const std::vector<ObjectMesh>& meshes() const { return meshes_; }
  const std::vector<AnimationPose>& poses() const { return poses_; }
  int pose_of(int sample) const { return pose_of_sample_[static_cast<std::size_t>(sample)]; }
  const ItemBuffer& items(int pose) const { return items_[static_cast<std::size_t>(pose)]; }
  /// Index into meshes() of the job's object.
  int mesh_of(std::size_t object) const { return mesh_of_object_[object]; }
  const AnimationCamera& camera(int pose) const;
  glm::dmat4 object_to_camera(int mesh, int pose) const;
  glm::dmat4 world_to_clip(int pose) const;

  /// An affine map of the object's texture coordinates for all poses; width 0: it is never seen.
  TextureMapping find_mapping(std::size_t object) const;

  /// Share of every pixel that each of the job's objects covers.
  std::vector<std::vector<float>> coverages(int sample) const;
  /// The sample's sum of the layer's passes, three a pixel.
  std::vector<float> layer_picture(int sample, const AnimationLayer& layer) const;
  /// The layer of each of the job's objects.
  std::vector<ObjectLayer> segment(int sample, const AnimationLayer& layer, int threads,
                                   SegmentationReport* report) const;

  /// Pixels without a depth that is a number, of the pictures that cameras were checked by.
  int nan_depths() const { return nan_depths_; }

 private:
  void find_poses();
  void check_cameras();

  AnimationJob job_;
  std::vector<ObjectMesh> meshes_;
  std::vector<int> mesh_of_object_;
  std::vector<AnimationPose> poses_;
  std::vector<int> pose_of_sample_;
  std::vector<ItemBuffer> items_;
  int nan_depths_ = 0;
};

}  // namespace multum
