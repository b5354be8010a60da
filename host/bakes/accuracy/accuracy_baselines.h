// SPDX-License-Identifier: Apache-2.0
// Measures what users would pick instead of a bake, in the same way (host/bakes/accuracy/accuracy.h, texel centres):
// averaged normals, Toksvig, LEAN moments. Convolved Blinn-Phong without n . l, in double.
#pragma once

#include <string>
#include <vector>

#include "host/formats/image/normals/normal_map.h"

namespace multum {

enum class Baseline {
  kMip,           // the averaged normal, normalised
  kToksvig,       // exponent shortened by the averaged normal's length (Toksvig 2005)
  kLean,          // Gaussian of slopes with covariance Sigma + I/s (Olano and Baker 2010)
  kLeanJacobian,  // the same as a density per solid angle: divided by cos^3
};
const char* baseline_name(Baseline baseline);

struct BaselineRow {
  int level;
  Baseline baseline;
  double exponent;
  double error;  // relative L1
};

/// All levels, every texel. Normals are stored as 16-bit normalised values, as the bakes' lobes are; moments as floats.
std::vector<BaselineRow> measure_baselines(const NormalMap& map, const std::vector<double>& exponents, int threads);

}  // namespace multum
