// SPDX-License-Identifier: Apache-2.0
// Chooses the start of EM on the coarsest level, which has no parent to start from.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/asset/representation.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/plane_store.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {

/// The finest texels [x0, x1) x [y0, y1) of a map.
struct TexelRectangle {
  int x0, y0, x1, y1;
};

/// Returns `lobe_count` lobes of equal amplitude and kappa 20, far apart: first the normal farthest from the mean, then
/// repeatedly the normal farthest from all chosen normals. This is the method of Hochbaum and Shmoys, which Han et al.
/// 2007, section 7.1, use to choose among lobes. The function reads at most about 2^14 normals on a regular grid.
std::vector<MultumVmfLobe> farthest_first_lobes(const PlaneStore& map, const TexelRectangle& where, int lobe_count);

/// Converts the lobes to `representation`. The Gaussian of a lobe has the x and y of the lobe's mean. Its sigma^2 is 1
/// - |r|, which is 1/kappa for a narrow lobe. `is_shortened` states whether the normals are shortened
/// (PlaneStore::is_shortened()). The mean of a Gaussian is not shortened, so its x and y are those of the unit
/// direction.
std::vector<MultumVmfLobe> start_lobes(std::vector<MultumVmfLobe> lobes, Representation representation,
                                       bool is_shortened);

struct StartSearch {
  int lobe_count = 4;
  float kappa_max = 1000.0f;  // upper limit of kappa inside EM
  std::uint64_t seed = 1;
  int threads = 1;
  bool grows_starts = true;  // with 5 lobes or more, some trials grow from the best fits with two lobes fewer
};

/// Returns 1 to 24 starts for the coarsest level, sorted by error, the lowest first. They are the best of many EM fits
/// to a sample of the whole map, made in double precision. If EM started only from farthest_first_lobes(), it would end
/// in poor local optima, which every finer level inherits. For example, three wide lobes would share one flat area and
/// two facets of a groove, and the error at the coarsest level of the four-quarter map would be 64 %. With these
/// starts, it is 6 %.
std::vector<std::vector<MultumVmfLobe>> start_candidates(const PlaneStore& map, const StartSearch& search);

/// Makes a map with at most `side_max` texels per side. Each texel is a random normal from the part of the map that it
/// represents, so that coarse levels have the same distributions. The choice is random because a regular grid can miss
/// parts of a pattern that repeats. For example, when a knurled plate was sampled on a grid, three of its four
/// directions were lost.
NormalMap sample_proxy_map(const PlaneStore& map, int side_max, std::uint64_t seed);

/// Returns `count` half vectors, a multiple of 4, of lights and views spread over the upper hemisphere and weighted by
/// their cosines. A quarter turn about z maps the set to itself. None of them is used for the errors in
/// docs/evidence/ACCURACY.md.
std::vector<glm::dvec3> spread_half_vectors(int count);

}  // namespace multum
