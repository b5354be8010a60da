// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/decoder/wavelet_stream_decoder.h"

namespace multum {
namespace {

/// The position of the decoded value in the interval of a coefficient. It is below the middle, because small values are
/// more likely.
constexpr float kPlaceInInterval = 0.4f;

/// Bytes per texel of a plane. They hold the magnitude, the sign, the lowest bit plane, and the quadtree nodes, which
/// take 4/3 of a byte.
constexpr std::size_t kDenseBytes = 8;

/// Calls visit(place, band, value in steps) for every coefficient that is not zero.
template <class Visit>
void over_coefficients(const WaveletPlane& plane, Visit visit) {
  plane.over_found([&](std::size_t at) {
    const std::size_t x = at % plane.width(), y = at / plane.width();
    std::size_t t = 0;
    for (const WaveletPlane::Tree& tree : plane.trees()) {
      const WaveletBand& band = tree.band;
      if (x - band.x < band.width && y - band.y < band.height)
        break;  // below the band, the unsigned difference wraps and exceeds every size
      ++t;
    }
    const float magnitude =
        static_cast<float>(plane.magnitudes[at]) + kPlaceInInterval * static_cast<float>(1u << plane.known[at]);
    visit(at, t, plane.negative[at] ? -magnitude : magnitude);
    return true;
  });
}

}  // namespace

WaveletPlane::WaveletPlane(std::size_t width, std::size_t height)
    : magnitudes(width * height),
      negative(width * height),
      known(width * height),
      width_(width),
      found_((width * height + 63) / 64) {
  for (const WaveletBand& band : wavelet_bands(width, height)) {
    Tree tree;
    tree.band = band;
    for (std::size_t w = band.width, h = band.height;; w = (w + 1) / 2, h = (h + 1) / 2) {
      tree.levels.push_back({w, h, std::vector<std::uint8_t>(w * h)});
      if (w == 1 && h == 1) break;
    }
    for (std::size_t t = 0; t < trees_.size(); ++t)
      if (trees_[t].band.kind == band.kind && trees_[t].band.depth == band.depth + 1)
        tree.coarser = static_cast<int>(t);
    trees_.push_back(std::move(tree));
  }
}

bool WaveletPlane::significant(std::size_t tree, std::size_t level, std::size_t x, std::size_t y) const {
  const auto& levels = trees_[tree].levels;
  const Level& nodes = levels[std::min(level, levels.size() - 1)];
  return x < nodes.width && y < nodes.height && nodes.significant[y * nodes.width + x] != 0;
}

WaveletImage WaveletStreamDecoder::next_image(const WaveletImage* parent) {
  WaveletImage image;
  for (std::size_t p = 0; p < image.size() && !port_.exhausted(); ++p) {
    WaveletSurroundings around;
    around.parent = parent == nullptr ? nullptr : &(*parent)[p];
    around.luma = p == 0 ? nullptr : &image[0];
    around.has_parent = parent != nullptr;
    around.plane = p;
    const int bit_planes = syntax_.bit_planes(coder_, {}, p);
    if (bit_planes == 0 || port_.exhausted()) continue;
    if (account_ != nullptr && account_->is_over(dense_bytes(image) + kDenseBytes * width_ * height_)) break;
    image[p] = WaveletPlane(width_, height_);
    syntax_.plane(coder_, image[p], bit_planes, {}, around,
                  [this] { return port_.exhausted() || (account_ != nullptr && account_->is_cancelled()); });
  }
  return image;
}

std::vector<float> dequantized(const WaveletPlane& plane, std::span<const float> steps, float scale) {
  if (plane.is_empty()) return {};
  std::vector<float> coefficients(plane.magnitudes.size());
  over_coefficients(
      plane, [&](std::size_t at, std::size_t band, float value) { coefficients[at] = scale * steps[band] * value; });
  return coefficients;
}

void add_samples(const WaveletPlane& plane, std::span<const float> steps, float scale, std::span<float> samples) {
  std::vector<float> coefficients = dequantized(plane, steps, scale);
  if (coefficients.empty()) return;
  inverse_wavelet(plane.width(), coefficients.size() / plane.width(), coefficients);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] += coefficients[i];
}

SparseWaveletPlane::SparseWaveletPlane(const WaveletPlane& plane) {
  over_coefficients(plane, [&](std::size_t at, std::size_t band, float value) {
    coefficients_.push_back({static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(band), value});
  });
  coefficients_.shrink_to_fit();
}

void SparseWaveletPlane::add_coefficients(std::span<const float> steps, float scale,
                                          std::span<float> coefficients) const {
  for (const Coefficient& c : coefficients_) coefficients[c.at] += scale * steps[c.band] * c.value;
}

std::size_t dense_bytes(const WaveletImage& image) {
  std::size_t bytes = 0;
  for (const WaveletPlane& plane : image) bytes += kDenseBytes * plane.magnitudes.size();
  return bytes;
}

}  // namespace multum
