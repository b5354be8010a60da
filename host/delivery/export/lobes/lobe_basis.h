// SPDX-License-Identifier: Apache-2.0
// Chooses the contents of the channels of a lobe's layers (docs/reference/lobe_textures.md, "Lobes for GPUs"). A lobe
// has x, y, z = a r and the amplitude a. Its channels are x, y, s = a - z and a. Each channel stores only the part that
// cannot be predicted from the others:
//
//     x' = x - m_x a,   y' = y - m_y a,   s' = s - (c_x x + c_y y + c_a a),   a
//
// The coefficients come from weighted least squares over all texels of the lobe. s is a second moment: 1 - r_z is half
// the mean square of the normals' x and y, up to fourth-order terms. The spread 1 - |r|, multiplied by a, is therefore
// about s - (x^2 + y^2) / (2 a). If all lobes of one index point in similar directions, s' is small, so eight or
// sixteen bits are enough for the spread. Filtering s gives the exact s of a mixture, whereas a filtered spread would
// not include the differences between the texels.
#pragma once

#include <array>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "host/formats/asset/textures/lobe_texture.h"

namespace multum {

/// Returns x, y, s, a of a lobe.
glm::vec4 moments_of(const glm::vec4& lobe);

/// The coefficients of x', y', s' and a, and the ranges to which channels from 0 to 1 are mapped.
struct LobeBasis {
  glm::vec2 mean{0.0f};             // m_x, m_y
  glm::vec3 predictor{0.0f};        // c_x, c_y, c_a
  glm::vec4 low{0.0f}, high{1.0f};  // ranges of x', y', s', a

  glm::vec4 reduced(const glm::vec4& moments) const;
};

/// Fits the basis of lobe `lobe` over all stored levels from `first_level` on.
LobeBasis fit_lobe_basis(const MovmfMipmap& mipmap, int first_level, int lobe);

/// Returns the unpacking of four channels in the order x', y', s', a.
LobeUnpacking unpacking_of(const LobeBasis& basis);

/// Returns the unpacking of channels that hold x, y, s and a directly.
LobeUnpacking plain_unpacking();

}  // namespace multum
