// SPDX-License-Identifier: Apache-2.0
// Planar Gaussians (Tan et al. 2005) in baked files, and their rounding. A file of Gaussians is a file of lobes
// (host/formats/asset/lobes/movmf_mipmap.h) whose four channels mean
//
//   a mu_x, a mu_y, a (2 sigma^2 + |mu|^2), a        mu = mean (n_x, n_y), sigma^2 = variance of one coordinate
//
// All are linear in the normals, so a filter T(.) mixes them exactly: 2 sigma^2 = T(third) / T(a) - |T(a mu)/T(a)|^2.
// Near the rim, 2 sigma^2 is a small difference of two numbers near 1. If the two numbers were rounded independently,
// most of this difference would be lost. Therefore the third value is rounded last, about the rounded mean. The spread
// then has one rounding error instead of three (docs/reference/file_format.md, "Encodings of Gaussians").
#pragma once

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// Returns sigma^2 of a stored or filtered lobe. The result is never negative. It is 0 if a is 0.
float gmm_variance(const glm::vec4& lobe);

/// Converts a normal of level 0 to a lobe of amplitude 1. The normal is c n, and its length c includes the width of a
/// BRDF. The lobe is (x, y, x^2 + y^2 + 2 v) of the unit normal n, where v is the planar variance of the facets around
/// n (kernels/device/planar_sample.clh).
glm::vec3 rough_point(const glm::vec3& shortened);
/// The inverse of rough_point(). Returns c n, for renderers that have only the file.
glm::vec3 shortened_normal(const glm::vec3& rough_point);
/// Converts a normal of level 0 to a lobe of amplitude 1. The normal has unit length, or a length that includes the
/// width of a BRDF.
glm::vec3 point_of_normal(const glm::vec3& normal, bool is_shortened);
/// The inverse of point_of_normal(). For a unit normal, the third value follows from (x, y), except for rounding.
glm::vec3 normal_of_point(const glm::vec3& point, bool is_shortened);

/// Returns 1 / sigma^2 for the smallest sigma^2 that a lobe of amplitude 1 stores with an error of at most a quarter,
/// at any mean.
float gmm_kappa_max(StorageEncoding encoding);

/// Counts lobes that are narrower than gmm_kappa_max() allows. Single directions do not count.
SharpLobes count_sharp_gaussians(const MovmfLevel& level, StorageEncoding encoding, int threads);

/// Rounds rows of a level >= 1 to stored values.
void quantize_gmm(MovmfLevel& rows, StorageEncoding encoding, int threads);

/// Returns the largest value of the encoding's grid that does not exceed `value`. For kSnorm16, `value` must be in
/// 0..1.
float grid_below(double value, StorageEncoding encoding);

}  // namespace multum
