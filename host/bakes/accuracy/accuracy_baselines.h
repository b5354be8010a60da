// SPDX-License-Identifier: Apache-2.0
// Measures the alternatives to a bake, which are averaged normals, Toksvig and LEAN moments. Errors are measured at
// texel centres as in host/bakes/accuracy/accuracy.h, in double precision and with convolved Blinn-Phong without n . l.
#pragma once

#include <string>
#include <vector>

#include "host/formats/image/normals/normal_map.h"

namespace multum {

enum class Baseline {
  kMip,           // the averaged normal, normalised
  kToksvig,       // an exponent that is reduced according to the length of the averaged normal (Toksvig 2005)
  kLean,          // a Gaussian of slopes with covariance Sigma + I/s (Olano and Baker 2010)
  kLeanJacobian,  // LEAN divided by cos^3, which turns it into a density per solid angle
};
const char* baseline_name(Baseline baseline);

struct BaselineRow {
  int level;
  Baseline baseline;
  double exponent;
  double error;  // relative L1
};

/// Measures every texel of all levels. Normals are stored as 16-bit normalised values, like the lobes of bakes. Moments
/// are floats.
std::vector<BaselineRow> measure_baselines(const NormalMap& map, const std::vector<double>& exponents, int threads);

}  // namespace multum
