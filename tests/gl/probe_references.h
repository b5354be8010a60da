// SPDX-License-Identifier: Apache-2.0
// Filter matrices in ways that are slow and obvious, to check the parity probe by. No supersampling.
#pragma once

#include <map>
#include <vector>

#include "runtime_gl/animation/textured_renderer.h"
#include "runtime_gl/probe/filter_probe.h"

namespace multum::gl {

/// Weights by texel, for every pixel of the picture.
using ProbeRows = std::vector<std::map<std::uint32_t, double>>;

struct ProbeCase {
  const GlFunctions* gl;
  int width, height;
  std::vector<PlacedMesh> objects;
  std::size_t object;
  TextureMapping mapping;
  ProbeSampler sampler;
};

/// The picture of the object with these texels (RGBA, MipLayout's order), alpha = 1 where it is seen.
FloatImage draw_texels(const ProbeCase& probe, int supersampling, const std::vector<float>& texels);

/// One texel set at a time (section 3.2, "A simple but impractical algorithm").
ProbeRows probe_texel_by_texel(const ProbeCase& probe);

/// The paper's parallel method: every 6th texel of every 3rd level at once (8th where a direction is periodic), the
/// texel's identifier in the other channels all over its filter neighbourhood (fig. 4). Sides are powers of two.
ProbeRows probe_in_parallel(const ProbeCase& probe);

/// Weights computed from the texture coordinate and textureQueryLod, as GL 4.5 section 8.14 defines trilinear
/// filtering.
ProbeRows rows_by_query_lod(const ProbeCase& probe);

/// Largest difference between entries.
double largest_difference(const ProbeRows& a, const ProbeRows& b);

ProbeRows rows_of(const FilterMatrix& matrix);

}  // namespace multum::gl
