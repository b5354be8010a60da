// SPDX-License-Identifier: Apache-2.0
// Measures the filter matrix of texture inference from the GL itself (Hakura et al. 2000, section 3.2, "Obtaining
// matrix A"). The paper sets every sixth texel of every third level at once and renders 108 times; here all texels are
// set at once. A texel is of one of a few classes (texel_classes.h), and no footprint holds two texels of a class: one
// draw measures eight classes in as many channels, with two digits of the texel's number beside, as the paper keeps
// identifiers in other channels. One draw is enough for trilinear filtering of even sizes.
//
// Departures: float buffers make the paper's correction of truncated rows needless. Identifiers are weight * digit, so
// tiny weights cannot name their texel: these are placed by the texture coordinate, where the digits only choose
// between neighbours. How far an anisotropic footprint reaches is the driver's affair: every row is checked against a
// draw of a random texture, and classes are made wider while more than a thousandth of the rows fail. A row that fails
// in the end or does not sum to 1 is left out and counted.
#pragma once

#include "host/fields/inferred/filter_matrix.h"
#include "host/fields/inferred/texture_mapping.h"
#include "runtime_gl/gl/framebuffer.h"
#include "runtime_gl/gl/shader_program.h"
#include "runtime_gl/probe/placed_mesh.h"

namespace multum::gl {

struct ProbeSampler {
  float anisotropy = 1.0f;  // 1..16
  bool has_mips = true;     // false: bilinear, level 0 alone
};

class FilterProbe {
 public:
  /// Pictures of width x height pixels, each of supersampling^2 sub-pixels. Throws Error(kEnvironment).
  FilterProbe(const GlFunctions& gl, int width, int height, int supersampling);

  /// The matrix of objects[object] with a texture as `mapping` says (size and wrap modes; the mesh's coordinates are
  /// mapped already), where the other objects leave it visible. Provenance is the caller's to fill in. `threads`: of
  /// decoding; the result does not depend on it.
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
