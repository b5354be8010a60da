// SPDX-License-Identifier: Apache-2.0
// A baked file of spherical harmonics without a bake, from the definition in double.
#pragma once

#include "host/formats/asset/averages/sh_mipmap.h"
#include "runtime_gl/materials/normal_material.h"

namespace multum::gl {

/// Of the image's normals, every level the mean of the finest. The sides are powers of two. Below 1: with a BRDF's
/// width in, of that mean cosine everywhere.
ShMipmap make_harmonics(const NormalImage& image, int order, StorageEncoding encoding, double mean_cosine = 1.0);

}  // namespace multum::gl
