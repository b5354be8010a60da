// SPDX-License-Identifier: Apache-2.0
// Computes the baseline of texture inference: "forward mapping" (Hakura et al. 2000, sections 3.2 and 3.3), which
// ignores OpenGL's filter. Every pixel's colour is added bilinearly to the four texels around its texture coordinate,
// and texels are normalized. Texels without pixels are filled from coarser levels (pull-push). Mip levels are
// box-filtered. The paper's baseline uses a Lanczos-windowed sinc of 16 x 16 taps instead of bilinear weights, and
// reflects the layer at its borders instead of filling the texels there. This version spreads a pixel less far and has
// no ringing.
#pragma once

#include <vector>

#include "host/fields/inference/mapping/item_buffer.h"
#include "host/fields/inference/mapping/layer_segmentation.h"
#include "host/fields/inferred/texture_mapping.h"
#include "host/formats/mesh/object_mesh.h"

namespace multum {

struct ForwardView {
  glm::dmat4 object_to_clip;
  const ItemBuffer* items;
  int object;  // the object's number in the item buffer
  const ObjectLayer* layer;
};

/// Returns three values per texel in the order of MipLayout, in the layer's units.
std::vector<float> forward_mapped(const ObjectMesh& mesh, const TextureMapping& mapping,
                                  const std::vector<ForwardView>& views);

}  // namespace multum
