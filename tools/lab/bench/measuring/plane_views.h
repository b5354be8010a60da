// SPDX-License-Identifier: Apache-2.0
// Filter matrices as texture inference meets them, without a GL: pictures of a plane that repeats a texture, seen in
// perspective by cameras that stand around it, sampled trilinearly as the GL does (OpenGL 4.5, section 8.14).
#pragma once

#include <vector>

#include "host/fields/inferred/filter_matrix.h"

namespace multum::bench {

struct PlaneView {
  int texture_side = 512;  // a power of two; the picture is 5/4 of it wide and 15/16 of it high
  int camera = 0;          // each looks in another direction
  int sub_pixels = 1;      // along each side of a pixel; the rows of a pixel's are averaged, as multum-view does
};

FilterMatrix plane_filter_matrix(const PlaneView& view, int threads);

/// Three colours a texel, noise within `contrast` of 0.5, every level the mean of the finer one.
std::vector<float> plane_texels(const MipLayout& layout, double contrast);

}  // namespace multum::bench
