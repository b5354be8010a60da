// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/wavelet_stream_encoder.h"

#include <cmath>

namespace multum {
namespace {

/// A coded coefficient must be worth at least this many bits. Isolated coefficients take more bits, but they save bits
/// in the pyramid's finer images. If this value is 6, files of field_demo1 are longer for the same error.
constexpr float kBitsOfFinding = 2.0f;

std::vector<std::int32_t> quantized(const WaveletTarget& target, std::size_t plane, const WaveletPlane& shape) {
  constexpr float kValueMax = (1 << WaveletPlane::kBitPlanes) - 1;
  std::vector<std::int32_t> values(shape.magnitudes.size());
  for (std::size_t t = 0; t < shape.trees().size(); ++t) {
    const WaveletBand& band = shape.trees()[t].band;
    const float step = target.scale * target.steps[t];
    for (std::size_t y = band.y; y < band.y + band.height; ++y)
      for (std::size_t x = band.x; x < band.x + band.width; ++x) {
        const std::size_t at = y * shape.width() + x;
        const float wanted = target.coefficients[plane][at];
        const float magnitude = std::min(std::floor(std::abs(wanted) / step), kValueMax);
        if (magnitude == 0.0f || target.weights[at] * wanted * wanted <= kBitsOfFinding * target.lambda) continue;
        values[at] = static_cast<std::int32_t>(wanted < 0.0f ? -magnitude : magnitude);
      }
  }
  return values;
}

WaveletSource source_of(const std::vector<std::int32_t>& values, const WaveletPlane& shape) {
  WaveletSource source;
  source.values = &values;
  for (const auto& tree : shape.trees()) {
    std::vector<std::vector<std::uint32_t>> levels;
    for (std::size_t l = 0; l < tree.levels.size(); ++l) {
      const auto& nodes = tree.levels[l];
      levels.emplace_back(nodes.width * nodes.height);
      for (std::size_t y = 0; y < nodes.height; ++y)
        for (std::size_t x = 0; x < nodes.width; ++x) {
          std::uint32_t largest = 0;
          if (l == 0) {
            largest = static_cast<std::uint32_t>(std::abs(values[(tree.band.y + y) * shape.width() + tree.band.x + x]));
          } else {
            const auto& below = tree.levels[l - 1];
            for (std::size_t cy = 2 * y; cy < std::min(2 * y + 2, below.height); ++cy)
              for (std::size_t cx = 2 * x; cx < std::min(2 * x + 2, below.width); ++cx)
                largest = std::max(largest, levels[l - 1][cy * below.width + cx]);
          }
          levels[l][y * nodes.width + x] = largest;
        }
    }
    source.largest.push_back(std::move(levels));
  }
  return source;
}

}  // namespace

WaveletImage WaveletStreamEncoder::add_image(const WaveletTarget& target, const WaveletImage* parent) {
  WaveletImage image;
  for (std::size_t p = 0; p < image.size(); ++p) {
    WaveletSurroundings around;
    around.parent = parent == nullptr ? nullptr : &(*parent)[p];
    around.luma = p == 0 ? nullptr : &image[0];
    around.has_parent = parent != nullptr;
    around.plane = p;
    WaveletPlane plane(width_, height_);
    const std::vector<std::int32_t> values = quantized(target, p, plane);
    const WaveletSource source = source_of(values, plane);
    const int bit_planes = syntax_.bit_planes(coder_, source, p);
    if (bit_planes == 0) continue;
    image[p] = std::move(plane);
    syntax_.plane(coder_, image[p], bit_planes, source, around, [] { return false; });
  }
  return image;
}

}  // namespace multum
