// SPDX-License-Identifier: Apache-2.0
// Computes the coefficients of all textures of a chunk together. A device can do this efficiently
// (host/fields/codec/transforms). The version in this file needs no device and uses the decoder's transforms.
#pragma once

#include <array>
#include <vector>

#include "host/fields/codec/decoder/texture_chunk_format.h"

namespace multum {

/// The layout of an image's coefficients.
struct CoefficientLayout {
  ImageCoder coder = ImageCoder::kDct;
  std::size_t width = 1, height = 1;  // texels
  std::size_t side = 16;              // side of cosine blocks

  /// Returns the number of coefficients per plane. Cosines are [block][v][u], and wavelets are [height][width].
  std::size_t coefficient_count() const;
};

/// Converts red, green and blue to three planes. Plane p is rows[p] . colour - offsets[p].
struct PlaneAxes {
  std::array<std::array<float, 3>, 3> rows{};
  std::array<float, 3> offsets{};
};

/// The planes of one texture. Each has layout.coefficient_count() numbers.
using PlaneCoefficients = std::array<std::vector<float>, 3>;

class ImageTransforms {
 public:
  ImageTransforms() = default;
  ImageTransforms(const ImageTransforms&) = delete;
  ImageTransforms& operator=(const ImageTransforms&) = delete;
  virtual ~ImageTransforms() = default;

  /// Each of the `textures` is [height][width][3]. Several threads may call this function at once. The result does not
  /// depend on the number of threads.
  virtual std::vector<PlaneCoefficients> coefficients(const CoefficientLayout& layout,
                                                      const std::vector<std::vector<float>>& textures,
                                                      const PlaneAxes& axes) = 0;
};

/// Computes coefficients without a device.
class HostImageTransforms : public ImageTransforms {
 public:
  std::vector<PlaneCoefficients> coefficients(const CoefficientLayout& layout,
                                              const std::vector<std::vector<float>>& textures,
                                              const PlaneAxes& axes) override;
};

}  // namespace multum
