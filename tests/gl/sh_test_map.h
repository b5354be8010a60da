// SPDX-License-Identifier: Apache-2.0
// Makes a baked file of spherical harmonics from the definition in double, without a bake.
#pragma once

#include "host/formats/asset/averages/sh_mipmap.h"
#include "runtime_gl/materials/normal_material.h"

namespace multum::gl {

/// Projects the image's normals; every level is an average of the finest level. The sides are powers of two. A
/// mean_cosine below 1 includes the width of a BRDF with this mean cosine everywhere.
ShMipmap make_harmonics(const NormalImage& image, int order, StorageEncoding encoding, double mean_cosine = 1.0);

}  // namespace multum::gl
