// SPDX-License-Identifier: Apache-2.0
// Reads the scene of an inference job for the stages of the inference. The scene includes meshes, poses, visibility,
// and the objects' layers of each sample (Hakura et al. 2000, section 3.1). Pictures are read on request and not kept.
#pragma once

#include <string>
#include <vector>

#include "host/fields/inference/job/animation_job.h"
#include "host/fields/inference/mapping/forward_mapping.h"
#include "host/fields/inference/mapping/item_buffer.h"
#include "host/fields/inference/mapping/layer_segmentation.h"
#include "host/fields/inference/mapping/parameter_grid.h"
#include "host/fields/inferred/texture_mapping.h"
#include "host/formats/image/files/exr_layers.h"
#include "host/formats/mesh/object_mesh.h"

namespace multum {

/// Throws Error(kInput) if a picture does not have the job's size.
void check_size(const AnimationJob& job, const std::string& path, const ExrLayers& layers);

class ParameterizedScene {
 public:
  /// Reads the geometry. If there is a depth channel, checks one picture of every pose against its camera
  /// (camera_check.h). Throws Error(kInput).
  explicit ParameterizedScene(AnimationJob job);

  const AnimationJob& job() const { return job_; }
  const std::vector<ObjectMesh>& meshes() const { return meshes_; }
  const ParameterGrid& grid() const { return grid_; }
  const std::vector<AnimationPose>& poses() const { return grid_.poses(); }
  int pose_of(int sample) const { return grid_.pose_of(sample); }
  const ItemBuffer& items(int pose) const { return items_[static_cast<std::size_t>(pose)]; }
  /// Returns the index into meshes() of the job's object.
  int mesh_of(std::size_t object) const { return mesh_of_object_[object]; }
  const AnimationCamera& camera(int pose) const;
  glm::dmat4 object_to_camera(int mesh, int pose) const;
  glm::dmat4 world_to_clip(int pose) const;
  /// Returns the job's object in the form that forward mapping reads. `layer` must outlive the result.
  ForwardView forward_view(std::size_t object, int pose, const ObjectLayer& layer) const;

  /// Returns an affine map of the object's texture coordinates for the poses of one block. The width is 0 if the object
  /// is not visible in these poses.
  TextureMapping find_mapping(std::size_t object, int block) const;

  /// Returns the share of every pixel that each of the job's objects covers.
  std::vector<std::vector<float>> coverages(int sample) const;
  /// Returns the sample's sum of the layer's passes, three values per pixel.
  std::vector<float> layer_picture(int sample, const AnimationLayer& layer) const;
  /// Returns the layer of each of the job's objects.
  std::vector<ObjectLayer> segment(int sample, const AnimationLayer& layer, int threads,
                                   SegmentationReport* report) const;

  /// Returns the number of NaN depths in the pictures that were used to check cameras.
  int nan_depths() const { return nan_depths_; }

 private:
  void draw_items();
  std::vector<PlacedObject> placed(int pose) const;
  void unmix_silhouettes(int pose, std::vector<std::vector<float>>& coverages) const;
  void check_cameras();

  AnimationJob job_;
  ParameterGrid grid_;
  std::vector<ObjectMesh> meshes_;
  std::vector<int> mesh_of_object_;
  std::vector<ItemBuffer> items_;
  int nan_depths_ = 0;
};

}  // namespace multum
