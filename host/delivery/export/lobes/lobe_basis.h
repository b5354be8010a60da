// SPDX-License-Identifier: Apache-2.0
// Chooses what the channels of a lobe's layers hold (docs/reference/lobe_textures.md, "Lobes for GPUs"). Of x, y, z = a
// r and the amplitude a the channels are x, y, s = a - z and a, each less what the others tell of it:
//
//     x' = x - m_x a,   y' = y - m_y a,   s' = s - (c_x x + c_y y + c_a a),   a
//
// by weighted least squares over all texels of the lobe. s is a second moment: 1 - r_z is half the mean square of the
// normals' x and y, but for terms of fourth order. So the spread 1 - |r| is what is left of s without the squares of x
// and y over a, and s' is small where lobes of one number point one way: eight or sixteen bits then keep the spread.
// A filter gives s of a mixture exactly, which a stored spread would not: that lacks what lies between the texels.
#pragma once

#include <array>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "host/formats/asset/textures/lobe_texture.h"

namespace multum {

/// x, y, s, a of a lobe.
glm::vec4 moments_of(const glm::vec4& lobe);

/// What x', y', s' and a are made of; and their ranges, which channels from 0 to 1 span.
struct LobeBasis {
  glm::vec2 mean{0.0f};             // m_x, m_y
  glm::vec3 predictor{0.0f};        // c_x, c_y, c_a
  glm::vec4 low{0.0f}, high{1.0f};  // of x', y', s', a

  glm::vec4 reduced(const glm::vec4& moments) const;
};

/// Of lobe `lobe` of all stored levels from `first_level` on.
LobeBasis fit_lobe_basis(const MovmfMipmap& mipmap, int first_level, int lobe);

/// The unpacking of four channels in the order x', y', s', a.
LobeUnpacking unpacking_of(const LobeBasis& basis);

/// Of channels that are x, y, s and a themselves.
LobeUnpacking plain_unpacking();

}  // namespace multum
