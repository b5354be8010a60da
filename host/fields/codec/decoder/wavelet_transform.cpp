// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/decoder/wavelet_transform.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace multum {
namespace {

constexpr int kDepthMax = 6;
constexpr std::size_t kSideMin = 8;

// The lifting steps, which predict and update in turn (Daubechies and Sweldens 1998, section 7.7). The factor gives
// low-pass filters a gain of sqrt(2), as in orthonormal filters.
constexpr std::array<float, 4> kSteps = {-1.586134342f, -0.05298011854f, 0.8829110762f, 0.4435068522f};
constexpr float kScale = 1.149604398f;

/// Several lines at once, split into even and odd samples. The element evens[i * lines + c] is even sample i of line c.
struct PartedLines {
  std::vector<float> evens, odds;
  std::size_t lines;

  /// Lines must have at least two samples.
  PartedLines(std::size_t length, std::size_t line_count)
      : evens((length + 1) / 2 * line_count), odds(length / 2 * line_count), lines(line_count) {}
};

/// Computes odd i += factor (even i + even i + 1), mirrored at the end. One loop covers all lines, which helps the
/// compiler.
void lift_odds(PartedLines& parted, float factor) {
  auto& [evens, odds, lines] = parted;
  const std::size_t inner = std::min(odds.size(), evens.size() - lines);
  for (std::size_t j = 0; j < inner; ++j) odds[j] += factor * (evens[j] + evens[j + lines]);
  for (std::size_t j = inner; j < odds.size(); ++j) odds[j] += factor * (evens[j] + evens[j]);
}

/// Computes even i += factor (odd i - 1 + odd i), mirrored at both ends.
void lift_evens(PartedLines& parted, float factor) {
  auto& [evens, odds, lines] = parted;
  for (std::size_t j = 0; j < lines; ++j) evens[j] += factor * (odds[j] + odds[j]);
  for (std::size_t j = lines; j < odds.size(); ++j) evens[j] += factor * (odds[j - lines] + odds[j]);
  for (std::size_t j = std::max(lines, odds.size()); j < evens.size(); ++j)
    evens[j] += factor * (odds[j - lines] + odds[j - lines]);
}

void forward_lines(PartedLines& parted) {
  for (std::size_t step = 0; step < 4; ++step)
    step % 2 == 0 ? lift_odds(parted, kSteps[step]) : lift_evens(parted, kSteps[step]);
  for (float& value : parted.evens) value *= kScale;
  for (float& value : parted.odds) value *= 1.0f / kScale;
}

void inverse_lines(PartedLines& parted) {
  for (float& value : parted.evens) value /= kScale;
  for (float& value : parted.odds) value *= kScale;
  for (std::size_t step = 4; step-- > 0;)
    step % 2 == 0 ? lift_odds(parted, -kSteps[step]) : lift_evens(parted, -kSteps[step]);
}

/// Transforms every row or column of the rectangle at the image's corner. Lines of one sample do not change. Samples
/// are in spatial order before a forward transform. Afterwards the low halves come first.
template <bool kForward>
void over_lines(std::span<float> image, std::size_t stride, std::size_t width, std::size_t height, bool rows) {
  const std::size_t length = rows ? width : height, count = rows ? height : width, low = (length + 1) / 2;
  if (length < 2) return;
  // Processes as many columns at once as fit into the first-level cache. The samples of a row are adjacent in any case.
  const std::size_t at_once = rows ? 1 : std::min<std::size_t>(32, count);
  PartedLines parted(length, at_once);
  for (std::size_t first = 0; first < count; first += at_once) {
    const std::size_t lines = std::min(at_once, count - first);
    if (lines != parted.lines) parted = PartedLines(length, lines);
    float* const corner = image.data() + (rows ? first * stride : first);
    const std::size_t step = rows ? 1 : stride;
    const auto over_samples = [&](bool in_order, const auto& visit) {
      for (std::size_t i = 0; i < low; ++i) visit(corner + (in_order ? 2 * i : i) * step, &parted.evens[i * lines]);
      for (std::size_t i = 0; i < length - low; ++i)
        visit(corner + (in_order ? 2 * i + 1 : low + i) * step, &parted.odds[i * lines]);
    };
    if (rows) over_samples(kForward, [](const float* from, float* to) { *to = *from; });
    else over_samples(kForward, [&](const float* from, float* to) { std::copy_n(from, lines, to); });
    if constexpr (kForward) forward_lines(parted);
    else inverse_lines(parted);
    if (rows) over_samples(!kForward, [](float* to, const float* from) { *to = *from; });
    else over_samples(!kForward, [&](float* to, const float* from) { std::copy_n(from, lines, to); });
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
    for (const bool rows : {true, false}) over_lines<true>(samples, width, halved(width, d), halved(height, d), rows);
}

void inverse_wavelet(std::size_t width, std::size_t height, std::span<float> coefficients) {
  for (int d = wavelet_depth(width, height); d-- > 0;)
    for (const bool rows : {false, true})
      over_lines<false>(coefficients, width, halved(width, d), halved(height, d), rows);
}

}  // namespace multum
