// SPDX-License-Identifier: Apache-2.0
// Makes filter matrices as in texture inference, without GL: pictures of a plane with a repeated texture, seen in
// perspective by cameras around it, with trilinear sampling as in GL (OpenGL 4.5, section 8.14).
#pragma once

#include <vector>

#include "host/fields/inferred/filter_matrix.h"

namespace multum::bench {

struct PlaneView {
  int texture_side = 512;  // a power of two; the picture has 5/4 of its width and 15/16 of its height
  int camera = 0;          // number of the camera; each looks in another direction
  int sub_pixels = 1;      // along each side of a pixel; rows of sub-pixels are averaged as in multum-view
};

FilterMatrix plane_filter_matrix(const PlaneView& view, int threads);

/// Three colours per texel, noise within `contrast` of 0.5; every level is the mean of the finer level.
std::vector<float> plane_texels(const MipLayout& layout, double contrast);

}  // namespace multum::bench
