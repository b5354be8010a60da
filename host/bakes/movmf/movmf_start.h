// SPDX-License-Identifier: Apache-2.0
// Chooses where EM starts on the coarsest level, which has no parent to start from.
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

/// `lobe_count` lobes of equal amplitude and kappa 20, far apart: the normal farthest from the mean first, then each
/// time the one farthest from those chosen (Hochbaum and Shmoys; Han et al. 2007, section 7.2, choose among lobes so).
/// At most about 2^14 normals on a regular grid are looked at.
std::vector<MultumVmfLobe> farthest_first_lobes(const PlaneStore& map, const TexelRectangle& where, int lobe_count);

/// The same lobes as `representation` has them: of Gaussians the mean's x and y, and sigma^2 = 1 - |r|, which is
/// 1/kappa of a narrow lobe. `is_shortened`: their normals are (PlaneStore::is_shortened()), and points of the plane
/// are not: the direction's x and y.
std::vector<MultumVmfLobe> start_lobes(std::vector<MultumVmfLobe> lobes, Representation representation,
                                       bool is_shortened);

struct StartSearch {
  int lobe_count = 4;
  float kappa_max = 1000.0f;  // cap inside EM
  std::uint64_t seed = 1;
  int threads = 1;
  bool grows_starts = true;  // some trials of 5 lobes and more grow from the best of two fewer
};

/// Starts for the coarsest level, least error first, 1 to 24: the best of many EM fits, in double,
/// to a sample of the whole map. EM from the farthest-first choice alone ends in poor local optima (one flat and two
/// facets of a groove shared by three wide lobes: 64 % error at the coarsest level of the four-quarter map, 6 % from
/// here), and every finer level inherits them.
std::vector<std::vector<MultumVmfLobe>> start_candidates(const PlaneStore& map, const StartSearch& search);

/// A map of at most `side_max` a side, each of whose texels is a normal picked at random from the part of the map that
/// it stands for: the same distributions at coarse levels. At random, because patterns repeat: a knurled plate sampled
/// on a grid lost three of its four directions.
NormalMap sample_proxy_map(const PlaneStore& map, int side_max, std::uint64_t seed);

/// `count`, a multiple of 4, half vectors of lights and views that are spread over the upper hemisphere, weighted by
/// their cosines: what a surface is lit by and seen from. The same after a quarter turn about z; none of those that
/// docs/evidence/ACCURACY.md judges by.
std::vector<glm::dvec3> spread_half_vectors(int count);

}  // namespace multum
