// SPDX-License-Identifier: Apache-2.0
#include "host/codec/decoder/wavelet_transform.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace multum {
namespace {

constexpr int kDepthMax = 6;
constexpr std::size_t kSideMin = 8;

// The lifting steps, predict and update in turn (Daubechies and Sweldens 1998, section 7.7), and the factor that brings
// low-pass filters to a gain of sqrt(2), as orthonormal ones have.
constexpr std::array<float, 4> kSteps = {-1.586134342f, -0.05298011854f, 0.8829110762f, 0.4435068522f};
constexpr float kScale = 1.149604398f;

/// line[i] += factor (line[i - 1] + line[i + 1]) for every other i, beginning with `first`; mirrored at the ends.
void lift(std::span<float> line, std::size_t first, float factor) {
  const std::size_t n = line.size();
  for (std::size_t i = first; i < n; i += 2) {
    const float before = line[i > 0 ? i - 1 : 1], after = line[i + 1 < n ? i + 1 : n - 2];
    line[i] += factor * (before + after);
  }
}

void forward_line(std::span<float> line, std::span<float> halves) {
  const std::size_t n = line.size(), low = (n + 1) / 2;
  for (std::size_t step = 0; step < 4; ++step) lift(line, step % 2 == 0 ? 1 : 0, kSteps[step]);
  for (std::size_t i = 0; i < n; ++i)
    halves[i % 2 == 0 ? i / 2 : low + i / 2] = line[i] * (i % 2 == 0 ? kScale : 1.0f / kScale);
}

void inverse_line(std::span<const float> halves, std::span<float> line) {
  const std::size_t n = line.size(), low = (n + 1) / 2;
  for (std::size_t i = 0; i < n; ++i) line[i] = i % 2 == 0 ? halves[i / 2] / kScale : halves[low + i / 2] * kScale;
  for (std::size_t step = 4; step-- > 0;) lift(line, step % 2 == 0 ? 1 : 0, -kSteps[step]);
}

/// Applies `turn` to every row or column of the rectangle at the image's corner; lines of one sample stay as they are.
template <class Turn>
void over_lines(std::span<float> image, std::size_t stride, std::size_t width, std::size_t height, bool rows,
                Turn turn) {
  const std::size_t length = rows ? width : height, count = rows ? height : width;
  if (length < 2) return;
  std::vector<float> line(length), result(length);
  for (std::size_t k = 0; k < count; ++k) {
    const auto at = [&](std::size_t i) -> float& { return rows ? image[k * stride + i] : image[i * stride + k]; };
    for (std::size_t i = 0; i < length; ++i) line[i] = at(i);
    turn(line, result);
    for (std::size_t i = 0; i < length; ++i) at(i) = result[i];
  }
}

std::size_t halved(std::size_t size, int times) {
  for (; times > 0; --times) size = (size + 1) / 2;
  return size;
}

}  // namespace

int wavelet_depth(std::size_t width, std::size_t height) {
  int depth = 0;
  for (std::size_t side = std::min(width, height); side >= kSideMin && depth < kDepthMax; side = (side + 1) / 2)
    ++depth;
  return depth;
}

std::vector<WaveletBand> wavelet_bands(std::size_t width, std::size_t height) {
  const int depth = wavelet_depth(width, height);
  std::vector<WaveletBand> bands = {{0, 0, halved(width, depth), halved(height, depth), std::max(depth, 1), 0}};
  for (int d = depth; d > 0; --d) {
    const std::size_t all_x = halved(width, d - 1), all_y = halved(height, d - 1);
    const std::size_t low_x = halved(width, d), low_y = halved(height, d);
    for (int kind = 1; kind <= 3; ++kind) {
      const bool high_x = kind % 2 == 1, high_y = kind >= 2;
      const WaveletBand band = {high_x ? low_x : 0,
                                high_y ? low_y : 0,
                                high_x ? all_x - low_x : low_x,
                                high_y ? all_y - low_y : low_y,
                                d,
                                kind};
      if (band.width > 0 && band.height > 0) bands.push_back(band);
    }
  }
  return bands;
}

void forward_wavelet(std::size_t width, std::size_t height, std::span<float> samples) {
  const int depth = wavelet_depth(width, height);
  for (int d = 0; d < depth; ++d)
    for (const bool rows : {true, false})
      over_lines(samples, width, halved(width, d), halved(height, d), rows,
                 [](std::vector<float>& line, std::vector<float>& halves) { forward_line(line, halves); });
}

void inverse_wavelet(std::size_t width, std::size_t height, std::span<float> coefficients) {
  for (int d = wavelet_depth(width, height); d-- > 0;)
    for (const bool rows : {false, true})
      over_lines(coefficients, width, halved(width, d), halved(height, d), rows,
                 [](std::vector<float>& halves, std::vector<float>& line) { inverse_line(halves, line); });
}

}  // namespace multum
