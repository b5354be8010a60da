// SPDX-License-Identifier: Apache-2.0
// Makes filter matrices like the matrices of texture inference, but without GL. The pictures show a plane with a
// repeated texture in perspective. The cameras are around the plane, and sampling is trilinear as in GL (OpenGL 4.5,
// section 8.14).
#pragma once

#include <vector>

#include "host/fields/inferred/filter_matrix.h"

namespace multum::bench {

struct PlaneView {
  int texture_side = 512;  // side of the texture, a power of two; the picture is 5/4 as wide and 15/16 as high
  int camera = 0;          // number of the camera; each camera looks in another direction
  int sub_pixels = 1;      // sub-pixels along each side of a pixel; their rows are averaged as in multum-view
};

FilterMatrix plane_filter_matrix(const PlaneView& view, int threads);

/// Returns three colours per texel: noise within `contrast` of 0.5. Every level is the mean of the finer level.
std::vector<float> plane_texels(const MipLayout& layout, double contrast);

}  // namespace multum::bench
