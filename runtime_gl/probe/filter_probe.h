// SPDX-License-Identifier: Apache-2.0
// Measures the filter matrix of texture inference with GL itself (Hakura et al. 2000, section 3.2, "Obtaining matrix
// A"). The paper sets every sixth texel of every third level at once and renders 108 times. Here all texels are set at
// once. Each texel belongs to one of a few classes (texel_classes.h), and no footprint contains two texels of a class.
// One draw measures eight classes in eight channels. Other channels measure two digits of the texel's number, like the
// paper's identifiers. Trilinear filtering of even sizes needs only one draw.
//
// Departures: with float buffers, the paper's correction of truncated rows is not needed. Identifiers are weight *
// digit, so a tiny weight cannot identify its texel. Such texels are found by the texture coordinate, and the digits
// only choose between neighbours. The reach of an anisotropic footprint depends on the driver. Therefore every row is
// checked against a draw of a random texture, and classes are made wider while more than a thousandth of the rows fail.
// A row that still fails, or whose weights do not sum to 1, is left out and counted.
#pragma once

#include "host/fields/inferred/filter_matrix.h"
#include "host/fields/inferred/texture_mapping.h"
#include "runtime_gl/gl/framebuffer.h"
#include "runtime_gl/gl/shader_program.h"
#include "runtime_gl/probe/placed_mesh.h"

namespace multum::gl {

struct ProbeSampler {
  float anisotropy = 1.0f;  // 1..16
  bool has_mips = true;     // if false, bilinear filtering of level 0 only
};

class FilterProbe {
 public:
  /// Draws pictures of width x height pixels with supersampling^2 sub-pixels each. Throws Error(kEnvironment).
  FilterProbe(const GlFunctions& gl, int width, int height, int supersampling);

  /// Returns the matrix of objects[object] for the pixels where the other objects do not hide it. `mapping` gives the
  /// texture's size and wrap modes. The mesh's coordinates are already mapped. The caller fills in the provenance.
  /// `threads` is for decoding and does not affect the result.
  FilterMatrix probe(const std::vector<PlacedMesh>& objects, std::size_t object, const TextureMapping& mapping,
                     const ProbeSampler& sampler, int threads) const;

 private:
  struct Pass;
  FilterMatrix probe_with_span(const Pass& pass, int span) const;
  void draw_band(const Pass& pass, int bottom_row) const;

  const GlFunctions& gl_;
  int width_, height_, supersampling_;
  Framebuffer framebuffer_;
  ShaderProgram probe_, occluder_;
};

}  // namespace multum::gl
