// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/picture_error.h"

#include <cmath>

#include "host/foundation/base/error.h"

namespace multum::gl {

PictureError picture_error(const FloatImage& picture, const FloatImage& reference) {
  MULTUM_CHECK(picture.rgba.size() == reference.rgba.size() && !reference.rgba.empty());
  double absolute = 0.0;
  double square = 0.0;
  double total = 0.0;
  for (std::size_t i = 0; i < reference.rgba.size(); ++i) {
    if (i % 4 == 3) continue;
    const double difference = static_cast<double>(picture.rgba[i]) - static_cast<double>(reference.rgba[i]);
    absolute += std::abs(difference);
    square += difference * difference;
    total += static_cast<double>(reference.rgba[i]);
  }
  const double count = 0.75 * static_cast<double>(reference.rgba.size());
  return {total > 0.0 ? absolute / total : absolute, std::sqrt(square / count)};
}

FloatImage difference_image(const FloatImage& picture, const FloatImage& reference, float gain) {
  MULTUM_CHECK(picture.rgba.size() == reference.rgba.size());
  FloatImage difference = picture;
  for (std::size_t i = 0; i < reference.rgba.size(); ++i)
    difference.rgba[i] = i % 4 == 3 ? 1.0f : gain * std::abs(picture.rgba[i] - reference.rgba[i]);
  return difference;
}

}  // namespace multum::gl
