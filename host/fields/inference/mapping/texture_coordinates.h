// SPDX-License-Identifier: Apache-2.0
// Finds texture coordinates for inference (Hakura et al. 2000, section 3.4). The result is a global affine map of an
// object's own texture coordinates for a block of parameter samples. Hidden parts get no texels, and visible parts are
// sampled finely enough. The steps are the branch cut, the least-squares isometric map (eq. 7), the stretch limit, the
// rectangle of least area, and the resolution.
#pragma once

#include <vector>

#include "host/fields/inference/job/animation_job.h"
#include "host/fields/inference/mapping/mapping_view.h"
#include "host/fields/inferred/texture_mapping.h"
#include "host/formats/mesh/object_mesh.h"

namespace multum {

/// Width and height are 0 if no view shows the object. Uses wrap, stretch_max, resolution_scale, power_of_two and
/// side_max of `texture`.
TextureMapping optimise_texture_mapping(const ObjectMesh& mesh, const std::vector<MappingView>& views,
                                        const AnimationTexture& texture);

}  // namespace multum
