// SPDX-License-Identifier: Apache-2.0
// Makes a baked file of spherical harmonics without a bake, from their definition in double precision.
#pragma once

#include "host/formats/asset/averages/sh_mipmap.h"
#include "runtime_gl/materials/normal_material.h"

namespace multum::gl {

/// Projects the normals of the image. Every level is an average of the finest level, and the sides are powers of two.
/// If mean_cosine is below 1, every texel includes the width of a BRDF with this mean cosine.
ShMipmap make_harmonics(const NormalImage& image, int order, StorageEncoding encoding, double mean_cosine = 1.0);

}  // namespace multum::gl
