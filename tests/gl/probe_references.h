// SPDX-License-Identifier: Apache-2.0
// Measures filter matrices in slow and simple ways, to check the parity probe. None of them uses supersampling.
#pragma once

#include <map>
#include <vector>

#include "runtime_gl/animation/textured_renderer.h"
#include "runtime_gl/probe/filter_probe.h"

namespace multum::gl {

/// Holds the weight of each texel for every pixel of the picture.
using ProbeRows = std::vector<std::map<std::uint32_t, double>>;

struct ProbeCase {
  const GlFunctions* gl;
  int width, height;
  std::vector<PlacedMesh> objects;
  std::size_t object;
  TextureMapping mapping;
  ProbeSampler sampler;
};

/// Draws the object with these texels (RGBA, in the order of MipLayout). Alpha is 1 where the object is visible.
FloatImage draw_texels(const ProbeCase& probe, int supersampling, const std::vector<float>& texels);

/// Measures by setting one texel at a time (section 3.2, "A simple but impractical algorithm").
ProbeRows probe_texel_by_texel(const ProbeCase& probe);

/// Measures with the paper's parallel method. Sets every 6th texel of every 3rd level at once, or every 8th texel along
/// a periodic direction. The other channels hold the identifier of that texel throughout its filter neighbourhood (fig.
/// 4). The sides are powers of two.
ProbeRows probe_in_parallel(const ProbeCase& probe);

/// Computes weights from the texture coordinate and textureQueryLod, by the trilinear filtering of GL 4.5 section 8.14.
ProbeRows rows_by_query_lod(const ProbeCase& probe);

/// Returns the largest difference between entries.
double largest_difference(const ProbeRows& a, const ProbeRows& b);

ProbeRows rows_of(const FilterMatrix& matrix);

}  // namespace multum::gl
