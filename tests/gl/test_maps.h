// SPDX-License-Identifier: Apache-2.0
// The plane that tests draw, and small maps whose exact mixtures are known, so that no bake is needed.
#pragma once

#include "runtime_gl/gl/mesh.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/render/scene.h"

namespace multum::gl {

/// `size` a side, its near edge along X through the origin, facing +Z. uv 0 to 1.
MeshData make_quad(float size);

struct TestMap {
  NormalImage image;
  MovmfMipmap mipmap;
};

/// Every normal (0, 0, 1): one lobe of |r| = 1.
TestMap make_flat_map(int size);

/// One lobe a texel of unit normals, box-filtered. The sides are powers of two and equal.
TestMap make_one_lobe_map(NormalImage image);

/// Normals at random, at most `slope` steep along each axis. One lobe. `size` is a power of two.
TestMap make_noise_map(int size, float slope, WrapMode wrap);

/// One wave along each axis, 0 at the borders: smooth under every wrap mode, but mirrored it is another map. One lobe.
/// `size` is a power of two.
TestMap make_wave_map(int size, WrapMode wrap);

/// A checkerboard of texels tilted by +angle and -angle (degrees) about Y, red and blue when `coloured`: two lobes of
/// |r| = 1, of amplitude 1/2 each from level 1 on. `size` is a power of two.
TestMap make_two_tilt_map(int size, double angle_degrees, StorageEncoding encoding, bool coloured);

/// A baked file of moments of the same normals, every level the mean of the finest. The sides are powers of two.
MomentMipmap make_moments(const NormalImage& image, StorageEncoding encoding);

/// The same map's lobes, each a single direction, as planar Gaussians of no variance; with roughness, each of its
/// facets'.
MovmfMipmap as_gaussians(MovmfMipmap mipmap);

/// From far enough that a pixel covers several texels of a 64-texel unit everywhere: level 1 and coarser.
RenderScene distant_scene();

/// Turns the camera down to the plane from 60 above it, with `texels` of a map of `size` to each pixel of a picture of
/// `height`.
void look_from_above(RenderScene& scene, double texels, int size, int height);

}  // namespace multum::gl
