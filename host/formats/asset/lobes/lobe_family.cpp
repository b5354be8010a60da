// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/lobes/lobe_family.h"

#include "host/formats/asset/lobes/gmm_quantize.h"
#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/foundation/base/error.h"

namespace multum {

const LobeFamily kSphericalLobes = {
    .is_planar = false,
    .one_lobe_is_mean = true,
    .plural = "lobes",
    .layer = "vMF",
    .lobe_text = "R,G,B,A = a*r.x,a*r.y,a*r.z,a; r = mean normal, +X right, +Y up, +Z out; data, not colour",
    .finest_text =
        "normalX, normalY = x, y; z = sqrt(max(0,1-x*x-y*y)), +X right, +Y up, +Z out; lobe = number of the "
        "lobe that has all of the texel; albedo = linear RGB; data, not colour",
    .finest_rough_text =
        "normalX, normalY, normalZ = c(roughness)*n, unit n +X right, +Y up, +Z out; lobe = number of the lobe that "
        "has all of the texel; albedo = linear RGB; data, not colour",
    .finest_rough_channel = "finest.normalZ.X",
    .finest_third_name = "a normal of z =",
    .quantize = quantize_movmf,
    .kappa_max = storage_kappa_max,
    .count_sharp = count_sharp_lobes,
    .finest_of_normal = [](const glm::vec3& normal, bool) { return normal; },
    .normal_of_finest = [](const glm::vec3& stored, bool) { return stored; },
    .quantize_finest = quantize_unit_vectors,
    .finest_third = finest_z,
    .is_single_direction = is_unit_vector};

const LobeFamily kPlanarLobes = {
    .is_planar = true,
    .one_lobe_is_mean = false,
    .plural = "Gaussians",
    .layer = "GMM",
    .lobe_text =
        "R,G,B,A = a*m.x,a*m.y,a*(2*s2+m.x*m.x+m.y*m.y),a; m = mean (x, y) of normals, +X right, +Y up; s2 = variance "
        "of one coordinate; data, not colour",
    .finest_text =
        "normalX, normalY = x, y of the normal, +X right, +Y up; lobe = number of the lobe that has all of the texel; "
        "albedo = linear RGB; data, not colour",
    .finest_rough_text =
        "normalX, normalY = x, y of the normal, +X right, +Y up; square = x*x+y*y+2*v, v = planar variance of the "
        "BRDF's facets; lobe = number of the lobe that has all of the texel; albedo = linear RGB; data, not colour",
    .finest_rough_channel = "finest.square.X",
    .finest_third_name = "a mean square of",
    .quantize = quantize_gmm,
    .kappa_max = gmm_kappa_max,
    .count_sharp = count_sharp_gaussians,
    .finest_of_normal = point_of_normal,
    .normal_of_finest = normal_of_point,
    .quantize_finest = quantize_points,
    .finest_third = finest_square,
    .is_single_direction = is_single_point};

const LobeFamily& lobe_family(Representation representation) {
  const LobeFamily* const family = representation_info(representation).lobes;
  MULTUM_CHECK(family != nullptr);
  return *family;
}

}  // namespace multum
