// SPDX-License-Identifier: Apache-2.0
// Checks that a camera fits its picture: depths of the picture, put back into the world, must lie on the objects.
#pragma once

#include <vector>

#include "host/fields/inference/job/animation_job.h"
#include "host/formats/mesh/object_mesh.h"

namespace multum {

struct CameraCheck {
  int tested = 0;                // pixels, at most 512
  int off = 0;                   // of them, further from the objects than the tolerance
  double distance_median = 0.0;  // of the tested pixels, world units
  int nan_depths = 0;            // of all pixels; left out
};

/// `depth`: the sample's depth channel, width * height, row 0 at the top; values that are not finite, not above 0 or
/// not nearer than the far plane are left out. `coverage`: share of each pixel that the objects cover; pixels that they
/// do not cover wholly are left out; empty: all pixels count. `objects`: of the geometry file; those that the sample
/// moves are placed by it. Throws Error(kInput) naming sample and camera when more than a tenth of the tested pixels
/// are off by more than job.depth_tolerance times their depth.
CameraCheck check_camera(const AnimationJob& job, const AnimationSample& sample, const std::vector<ObjectMesh>& objects,
                         const std::vector<float>& depth, const std::vector<float>& coverage);

}  // namespace multum
