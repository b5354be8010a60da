// SPDX-License-Identifier: Apache-2.0
// Texture coordinates for inference (Hakura et al. 2000, section 3.4): a global affine map of an object's own texture
// coordinates, for a block of parameter samples, that spends no texels on what is never seen and samples what is seen
// finely enough: branch cut, least-squares isometric map (eq. 7), stretch limit, rectangle of least area, resolution.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <glm/mat2x2.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include "host/bake/animation_job.h"
#include "host/bake/item_buffer.h"
#include "host/base/wrap_mode.h"
#include "host/mesh/object_mesh.h"

namespace multum {

/// One picture in which the object is seen.
struct MappingView {
  glm::dmat4 object_to_camera;
  glm::dmat4 projection;
  const ItemBuffer* items;
  int object;  // its number in the item buffer
};

/// texture coordinates (0..1 across the texture) = linear * (u', v') + offset, where u' = u, or in a direction with a
/// branch cut u' = u - floor(u - cut) in [cut, cut + 1).
struct TextureMapping {
  glm::dmat2 linear{1.0};
  glm::dvec2 offset{0.0};
  std::array<bool, 2> has_cut{false, false};
  std::array<double, 2> cut{0.0, 0.0};
  WrapMode wrap_s = WrapMode::kClamp, wrap_t = WrapMode::kClamp;
  int width = 1, height = 1;  // texels
  double stretch_max = 0.0;   // largest singular value of texels-to-pixels that remains over all visible pixels
  int stretch_rounds = 0;     // of scaling by it
  std::size_t visible_pixels = 0;
  std::size_t degenerate_pixels =
      0;  // of them, without a Jacobian: triangles that are a line in the texture or edge-on
};

/// The object's texture coordinates under the mapping, three per triangle in the order of `indices`: a cut may give a
/// vertex two. A triangle keeps its shape: where it straddles a cut, which no visible one does, it lies on one side
/// whole.
std::vector<glm::vec2> mapped_corners(const ObjectMesh& mesh, const TextureMapping& mapping);

/// Width and height 0 when the object is visible in no view. `texture` gives wrap, stretch_max, resolution_scale,
/// power_of_two and side_max.
TextureMapping optimise_texture_mapping(const ObjectMesh& mesh, const std::vector<MappingView>& views,
                                        const AnimationTexture& texture);

}  // namespace multum
