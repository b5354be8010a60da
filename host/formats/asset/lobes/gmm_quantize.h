// SPDX-License-Identifier: Apache-2.0
// Planar Gaussians (Tan et al. 2005) as a baked file has them, and their rounding. A file of them is one of lobes
// (host/formats/asset/lobes/movmf_mipmap.h) whose four channels mean
//
//   a mu_x, a mu_y, a (2 sigma^2 + |mu|^2), a        mu = mean (n_x, n_y), sigma^2 = variance of one coordinate
//
// All are linear in the normals, so that a filter T(.) mixes them exactly: 2 sigma^2 = T(third) / T(a) - |T(a
// mu)/T(a)|^2. Near the rim that is a small difference of numbers near 1: rounded one by one they leave little of it.
// So the third is rounded last, about the mean as it was rounded: one rounding instead of three,
// docs/reference/file_format.md, "Encodings of Gaussians".
#pragma once

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// sigma^2 of a stored or filtered lobe; never negative, 0 where a is 0.
float gmm_variance(const glm::vec4& lobe);

/// One finest normal, shortened to c n by a BRDF's width, as a lobe of amplitude 1: (x, y, x^2 + y^2 + 2 v) of the unit
/// normal, v the planar variance of its facets (kernels/device/planar_sample.clh says which).
glm::vec3 rough_point(const glm::vec3& shortened);
/// The other way round, for renderers that have the file alone: c n.
glm::vec3 shortened_normal(const glm::vec3& rough_point);
/// One finest normal, shortened or not, as a lobe of amplitude 1.
glm::vec3 point_of_normal(const glm::vec3& normal, bool is_shortened);
/// The other way round. What the third value adds to a unit normal's (x, y) is rounding.
glm::vec3 normal_of_point(const glm::vec3& point, bool is_shortened);

/// 1 / the least sigma^2 that a lobe of amplitude 1 keeps to within a quarter, wherever its mean is.
float gmm_kappa_max(StorageEncoding encoding);

/// Lobes narrower than that, but for single directions.
SharpLobes count_sharp_gaussians(const MovmfLevel& level, StorageEncoding encoding, int threads);

/// Rounds rows of a level >= 1 to what is stored.
void quantize_gmm(MovmfLevel& rows, StorageEncoding encoding, int threads);

/// The largest value of the encoding's grid that is not above `value`, 0..1 for kSnorm16.
float grid_below(double value, StorageEncoding encoding);

}  // namespace multum
