// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/image_transforms.h"

#include "host/fields/codec/dct_stream_encoder.h"
#include "host/fields/codec/decoder/wavelet_transform.h"

namespace multum {

std::size_t CoefficientLayout::coefficient_count() const {
  return coder == ImageCoder::kDct ? BlockGrid{width, height, side}.count() * side * side : width * height;
}

std::vector<PlaneCoefficients> HostImageTransforms::coefficients(const CoefficientLayout& layout,
                                                                 const std::vector<std::vector<float>>& textures,
                                                                 const PlaneAxes& axes) {
  std::vector<PlaneCoefficients> all;
  for (const auto& texture : textures) {
    PlaneCoefficients& of_texture = all.emplace_back();
    for (std::size_t p = 0; p < 3; ++p) {
      std::vector<float> plane(layout.width * layout.height, -axes.offsets[p]);
      for (std::size_t i = 0; i < plane.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) plane[i] += axes.rows[p][c] * texture[3 * i + c];
      if (layout.coder == ImageCoder::kDct) {
        of_texture[p] = block_coefficients({layout.width, layout.height, layout.side}, plane);
      } else {
        forward_wavelet(layout.width, layout.height, plane);
        of_texture[p] = std::move(plane);
      }
    }
  }
  return all;
}

}  // namespace multum
