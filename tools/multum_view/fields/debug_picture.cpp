// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/fields/debug_picture.h"

#include <algorithm>
#include <array>

namespace multum {
namespace {

using Colour = std::array<float, 3>;

constexpr int kBand = 16, kGap = 4, kDecoding = 64, kMemory = 64;  // pixels
constexpr std::size_t kWidthMax = 16384;
constexpr Colour kGreen = {0.05f, 0.45f, 0.1f}, kYellow = {0.9f, 0.7f, 0.05f}, kRed = {0.7f, 0.03f, 0.03f};
constexpr Colour kBlue = {0.1f, 0.25f, 0.9f}, kViolet = {0.6f, 0.1f, 0.7f}, kGrey = {0.25f, 0.25f, 0.25f};
constexpr Colour kWhite = {1.0f, 1.0f, 1.0f};

/// A column of the picture, which is filled from the top down.
class Column {
 public:
  Column(gl::FloatImage& image, int x, int width) : image_(image), x_(x), width_(width) {}

  /// Fills rows `first` to `end` of a band, which are counted upwards from the bottom of the band. The bottom is
  /// `bottom` rows below the top of the picture.
  void fill(int bottom, int first, int end, const Colour& colour) {
    for (int row = first; row < end; ++row)
      for (int x = x_; x < x_ + width_; ++x)
        for (std::size_t c = 0; c < 3; ++c)
          image_.rgba[4 * static_cast<std::size_t>((bottom - 1 - row) * image_.width + x) + c] = colour[c];
  }

 private:
  gl::FloatImage& image_;
  int x_, width_;
};

int rows_of(std::size_t part, std::size_t whole, int rows) {
  const double share = static_cast<double>(part) / static_cast<double>(std::max<std::size_t>(whole, 1));
  return std::clamp(static_cast<int>(share * rows + 0.5), part > 0 ? 1 : 0, rows);
}

}  // namespace

gl::FloatImage debug_picture(const std::vector<PlayedFrame>& frames, std::size_t memory_max) {
  const int layers = frames.empty() ? 0 : static_cast<int>(frames.front().layers.size());
  const int step = static_cast<int>(std::clamp<std::size_t>(kWidthMax / std::max<std::size_t>(frames.size(), 1), 1, 4));
  gl::FloatImage image;
  image.width = std::max(1, step * static_cast<int>(std::min(frames.size(), kWidthMax)));
  image.height = layers * (kBand + kGap) + kDecoding + kGap + kMemory;
  image.rgba.resize(4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 1.0f;
  for (std::size_t f = 0; f < std::min(frames.size(), kWidthMax); ++f) {
    const PlayedFrame& frame = frames[f];
    Column column(image, step * static_cast<int>(f), step);
    int bottom = 0;
    for (const gl::LayerReport& layer : frame.layers) {
      bottom += kBand;
      const int late = layer.is_old ? 0 : rows_of(layer.missing, layer.needed, kBand);
      if (layer.is_drawn) column.fill(bottom, 0, kBand, layer.is_old ? kRed : kGreen);
      if (layer.is_drawn) column.fill(bottom, kBand - late, kBand, kYellow);
      bottom += kGap;
    }
    bottom += kDecoding;
    const int images = static_cast<int>(std::min<std::size_t>(frame.images_decoded, kDecoding));
    const int chunks = static_cast<int>(std::min<std::size_t>(frame.chunks_decoded, kDecoding));
    column.fill(bottom, 0, images, kBlue);
    column.fill(bottom, images, std::min(images + chunks, kDecoding), kViolet);
    bottom += kGap + kMemory;
    const int peak = rows_of(frame.bytes_most, memory_max, kMemory);
    column.fill(bottom, 0, rows_of(frame.bytes, memory_max, kMemory), kGrey);
    column.fill(bottom, std::max(peak - 1, 0), peak, kWhite);
  }
  return image;
}

}  // namespace multum
