// SPDX-License-Identifier: Apache-2.0
// The baseline of texture inference: "forward mapping" (Hakura et al. 2000, sections 3.2 and 3.3), which knows nothing
// of the GL's filter. Every pixel's colour is put into the four texels around its texture coordinate, bilinearly;
// texels are normalised; what no pixel reached is filled from coarser levels (pull-push); mips are box-filtered. The
// paper's baseline has a Lanczos-windowed sinc of 16 x 16 taps in the place of the bilinear splat, and reflects the
// layer at its borders where this fills: ours spreads a pixel less far and has no ringing.
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
  int object;  // its number in the item buffer
  const ObjectLayer* layer;
};

/// Three a texel, MipLayout's order, in the layer's units.
std::vector<float> forward_mapped(const ObjectMesh& mesh, const TextureMapping& mapping,
                                  const std::vector<ForwardView>& views);

}  // namespace multum
