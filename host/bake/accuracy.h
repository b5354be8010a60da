// SPDX-License-Identifier: Apache-2.0
// How far a baked mipmap is from the truth. Truth: the average over every finest normal that a texel covers, in double.
// Model: the stored, rounded lobes, filtered linearly and shaded by the runtime's formula (kernels/movmf_shade.cl).
// Levels finer than the first that is stored: the normal map's own mips, in float, each texel one lobe with the mean
// vector of the normals that it covers; between them and the stored levels both are shaded and mixed, as renderers do.
// Error: relative L1 = sum |model - truth| / sum truth, over sampled texels and a fixed set of lights and views, of the
// BRDF's convolution alone, f without n . l (docs/ALGORITHMS.md).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "host/asset/movmf_mipmap.h"
#include "host/base/progress.h"
#include "host/image/normal_map.h"
#include "host/opencl/device.h"

namespace multum {

/// Where in the pyramid the model is evaluated.
enum class AccuracyPoint {
  kCentre,   // texel centres: no filtering
  kMidX,     // midway between a texel and its right neighbour
  kMidY,     // midway between a texel and the one below
  kBetween,  // a texel's centre, half-way to the next coarser level (bilinear there)
};
const char* accuracy_point_name(AccuracyPoint point);

struct AccuracyRow {
  int level;
  AccuracyPoint point;
  std::string brdf;   // "lambert", "blinn-phong:20"; with " coloured" when multiplied by the colours
  double error;       // relative L1, 0.1 = 10 %
  double confidence;  // half width of the 95 % interval of `error` over the sampled texels; 0 when all were used
  std::int64_t sample_count;  // texels
};

/// The lights and half vectors of every figure: 4 lights, 12 half vectors (docs/ACCURACY.md names them).
struct AccuracyDirections {
  std::vector<glm::dvec3> lights;        // at least one
  std::vector<glm::dvec3> half_vectors;  // at least one
};
AccuracyDirections accuracy_directions();

struct AccuracySettings {
  std::vector<double> exponents = {20.0, 100.0, 500.0};  // Blinn-Phong s, 1..1e5
  std::int64_t samples_per_level = 4096;                 // texels, spread evenly at random; 0: every texel
  std::uint64_t seed = 1;
  const ColourMap* albedo = nullptr;  // set: colours are compared too, per channel (the mipmap must have them)
  int first_level = 0;                // finer ones are not measured
  AccuracyDirections directions = accuracy_directions();
  int threads = 2;
};

/// `mipmap` must be of `map`'s size. The truth pass reads every normal once a half vector, whatever the samples.
std::vector<AccuracyRow> measure_accuracy(Device& device, const MovmfMipmap& mipmap, const NormalMap& map,
                                          const AccuracySettings& settings, Progress* progress);

}  // namespace multum
