// SPDX-License-Identifier: Apache-2.0
// Makes the coefficients of a chunk's textures, all of them together, so that a device may do it
// (host/fields/codec/transforms); here with the decoder's own transforms, for whoever has none.
#pragma once

#include <array>
#include <vector>

#include "host/fields/codec/decoder/texture_chunk_format.h"

namespace multum {

/// Places and kinds of the coefficients of an image.
struct CoefficientLayout {
  ImageCoder coder = ImageCoder::kDct;
  std::size_t width = 1, height = 1;  // texels
  std::size_t side = 16;              // of cosine blocks

  /// Of a plane: cosines [block][v][u], wavelets [height][width].
  std::size_t coefficient_count() const;
};

/// Three planes out of red, green and blue: plane p = rows[p] . colour - offsets[p].
struct PlaneAxes {
  std::array<std::array<float, 3>, 3> rows{};
  std::array<float, 3> offsets{};
};

/// Of one texture, each layout.coefficient_count() long.
using PlaneCoefficients = std::array<std::vector<float>, 3>;

class ImageTransforms {
 public:
  ImageTransforms() = default;
  ImageTransforms(const ImageTransforms&) = delete;
  ImageTransforms& operator=(const ImageTransforms&) = delete;
  virtual ~ImageTransforms() = default;

  /// `textures`: [height][width][3] each. May be called by several threads; the result does not depend on them.
  virtual std::vector<PlaneCoefficients> coefficients(const CoefficientLayout& layout,
                                                      const std::vector<std::vector<float>>& textures,
                                                      const PlaneAxes& axes) = 0;
};

/// Without a device.
class HostImageTransforms : public ImageTransforms {
 public:
  std::vector<PlaneCoefficients> coefficients(const CoefficientLayout& layout,
                                              const std::vector<std::vector<float>>& textures,
                                              const PlaneAxes& axes) override;
};

}  // namespace multum
