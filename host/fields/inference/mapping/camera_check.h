// SPDX-License-Identifier: Apache-2.0
// Checks that a camera fits its picture. The depths of the picture, projected back into the world, must give points on
// the objects.
#pragma once

#include <vector>

#include "host/fields/inference/job/animation_job.h"
#include "host/formats/mesh/object_mesh.h"

namespace multum {

struct CameraCheck {
  int tested = 0;                // number of tested pixels, at most 512
  int off = 0;                   // tested pixels whose distance to the objects exceeds the tolerance
  double distance_median = 0.0;  // median distance of the tested pixels from the objects, in world units
  int nan_depths = 0;            // number of pixels whose depth is NaN; such pixels are left out
};

/// `depth` is the sample's depth channel, with width * height values and row 0 at the top. Values are ignored unless
/// they are finite, above 0 and below the depth of the far plane. `coverage` is the share of each pixel that the
/// objects cover. Partly covered pixels are left out. If `coverage` is empty, all pixels count. `objects` come from the
/// geometry file, with moving objects placed by the sample. Throws Error(kInput), which names the sample and the
/// camera, if more than a tenth of the tested pixels miss the objects by more than job.depth_tolerance times their
/// depth.
CameraCheck check_camera(const AnimationJob& job, const AnimationSample& sample, const std::vector<ObjectMesh>& objects,
                         const std::vector<float>& depth, const std::vector<float>& coverage);

}  // namespace multum
