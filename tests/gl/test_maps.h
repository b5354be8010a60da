// SPDX-License-Identifier: Apache-2.0
// Makes the plane that tests draw, and small maps whose exact mixtures are known, so that no bake is needed.
#pragma once

#include "runtime_gl/gl/mesh.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/render/scene.h"

namespace multum::gl {

/// Makes a square with sides of length `size` that faces +Z. Its near edge runs along X through the origin, and its
/// texture coordinates go from 0 to 1.
MeshData make_quad(float size);

struct TestMap {
  NormalImage image;
  MovmfMipmap mipmap;
};

/// Every normal is (0, 0, 1), which gives one lobe of |r| = 1.
TestMap make_flat_map(int size);

/// Returns one lobe per texel, which a box filter makes from unit normals. The sides are equal powers of two.
TestMap make_one_lobe_map(NormalImage image);

/// Returns random normals with slopes of at most `slope` along each axis, as one lobe per texel. `size` is a power of
/// two.
TestMap make_noise_map(int size, float slope, WrapMode wrap);

/// Returns one wave along each axis, which is 0 at the borders, as one lobe per texel. The map is smooth with every
/// wrap mode, but mirroring makes a different map. `size` is a power of two.
TestMap make_wave_map(int size, WrapMode wrap);

/// Returns a checkerboard of texels that are tilted by +angle and -angle (degrees) about Y. If `coloured`, the texels
/// are red and blue. There are two lobes of |r| = 1. In level 1 and all coarser levels, both amplitudes are 1/2. `size`
/// is a power of two.
TestMap make_two_tilt_map(int size, double angle_degrees, StorageEncoding encoding, bool coloured);

/// Makes a baked file of moments from the normals of the image. Every level is the mean of the finest level, and the
/// sides are powers of two.
MomentMipmap make_moments(const NormalImage& image, StorageEncoding encoding);

/// Converts lobes of single directions to planar Gaussians. Their variance is 0 or, with roughness, the variance of the
/// facets.
MovmfMipmap as_gaussians(MovmfMipmap mipmap);

/// Returns a view from so far away that every pixel covers several texels and shows level 1 or a coarser level. The map
/// has 64 texels per unit.
RenderScene distant_scene();

/// Points the camera straight down at the plane from a height of 60. In a picture of `height` pixels, each pixel covers
/// `texels` of a map of `size` texels.
void look_from_above(RenderScene& scene, double texels, int size, int height);

}  // namespace multum::gl
