// SPDX-License-Identifier: Apache-2.0
// Tests the transforms of the animation codec (kernels/image_transform.cl). The inputs contain borders within blocks,
// lines shorter than their filter, and colours that cancel. The cases also check that the kernels write no memory after
// the last item.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/foundation/base/split_mix.h"
#include "host/lab/field_cases/field_case_lists.h"
#include "host/lab/field_cases/image_transform.h"
#include "host/lab/selftest/buffers.h"

namespace multum {
namespace {

constexpr std::size_t kItemsOfGroup = 64;  // launch sizes are rounded up to a multiple of this number
constexpr float kLeftAlone = -12345.0f;

Kernel transform_kernel(Device& device, const char* name) {
  return device.kernel("image_transform", name, {1, 1, false});
}

std::vector<float> random_list(std::size_t count, SplitMix64& random) {
  std::vector<float> list(count);
  for (float& value : list) value = static_cast<float>(255.0 * random.uniform());
  return list;
}

std::vector<double> as_doubles(const std::vector<float>& list) { return {list.begin(), list.end()}; }

// Compares `found` with `exact`. Errors are relative to the largest value, and the value after the results must still
// be kLeftAlone.
void add_all(const std::vector<float>& found, const std::vector<double>& exact, const std::string& input,
             WorstError& worst) {
  double most = 1e-30;
  for (const double value : exact) most = std::max(most, std::abs(value));
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::string at = fmt::format("{}, value {}", input, i);
    if (i < exact.size()) worst.add(static_cast<double>(found[i]), exact[i], most, at);
    else worst.add(found[i] == kLeftAlone ? 0.0 : 1.0, at);
  }
}

std::vector<float> room_for(std::size_t count) { return std::vector<float>(count + 40 * kItemsOfGroup, kLeftAlone); }

// Tests two nearly grey textures of 37 texels. The second and third planes contain differences near 0.
void colours_near_grey(Device& device, WorstError& worst) {
  constexpr std::size_t kTexelCount = 37, kTextures = 2;
  SplitMix64 random(61);
  std::vector<float> textures;
  for (std::size_t i = 0; i < kTexelCount * kTextures; ++i) {
    const double grey = 255.0 * random.uniform();
    for (int c = 0; c < 3; ++c) textures.push_back(static_cast<float>(grey + 1e-3 * random.uniform()));
  }
  std::vector<float> all = textures;
  all.resize(all.size() + 3 * kItemsOfGroup, 1.0f);
  const float a = std::sqrt(1.0f / 3.0f), b = std::sqrt(0.5f), c = std::sqrt(1.0f / 6.0f);
  const std::vector<float> axes = {a, a, a, 100.0f, b, -b, 0.0f, 0.25f, c, c, -2.0f * c, -0.5f};
  const DeviceBuffer planes = uploaded(device, room_for(3 * textures.size()), "planes");
  transform_kernel(device, "colour_planes")
      .launch({kTexelCount * kTextures, kItemsOfGroup}, uploaded(device, all, "textures"),
              uploaded(device, axes, "axes"), planes, static_cast<int>(kTextures), static_cast<int>(kTexelCount));
  std::vector<double> exact(textures.size());
  for (std::size_t t = 0; t < kTextures; ++t)
    for (std::size_t p = 0; p < 3; ++p)
      for (std::size_t i = 0; i < kTexelCount; ++i) {
        double sum = -static_cast<double>(axes[4 * p + 3]);
        for (std::size_t k = 0; k < 3; ++k)
          sum += static_cast<double>(axes[4 * p + k]) * static_cast<double>(textures[3 * (t * kTexelCount + i) + k]);
        exact[(3 * t + p) * kTexelCount + i] = sum;
      }
  add_all(downloaded<float>(device, planes), exact, "greys", worst);
}

// Tests images whose right and lower borders are inside blocks, images of one texel, and steps of 1e6.
void blocks_beyond_borders(Device& device, WorstError& worst) {
  SplitMix64 random(62);
  for (const int side : {8, 16, 32})
    for (const auto& [width, height] : {std::pair{1, 1}, {9, 8}, {33, 47}, {64, 5}}) {
      const auto texels = static_cast<std::size_t>(width * height);
      std::vector<float> images = random_list(2 * texels, random);
      for (std::size_t i = texels; i < images.size(); ++i) images[i] = i % 5 < 2 ? 1e6f : -1e-6f;
      std::vector<float> read = images;
      read.resize(images.size() + 64 * 64, 1e6f);  // a block that ignores the border reads these values
      std::vector<float> rows;
      for (int k = 0; k < side; ++k)
        for (int i = 0; i < side; ++i)
          rows.push_back(static_cast<float>(std::sqrt((k == 0 ? 1.0 : 2.0) / side) *
                                            std::cos(M_PI * (2 * i + 1) * k / (2.0 * side))));
      const DeviceBuffer cosines = uploaded(device, rows, "cosines");
      const std::size_t blocks =
          2u * static_cast<std::size_t>((width + side - 1) / side * ((height + side - 1) / side));
      const std::size_t lines = blocks * static_cast<std::size_t>(side),
                        values = lines * static_cast<std::size_t>(side);
      const DeviceBuffer half_way = uploaded(device, room_for(values), "half"),
                         coefficients = uploaded(device, room_for(values), "coefficients");
      transform_kernel(device, "dct_rows")
          .launch({lines, kItemsOfGroup}, uploaded(device, read, "images"), cosines, half_way, 2, width, height, side);
      transform_kernel(device, "dct_columns")
          .launch({lines, kItemsOfGroup}, half_way, cosines, coefficients, static_cast<int>(blocks), side);
      const std::vector<float> found = downloaded<float>(device, coefficients);
      for (std::size_t image = 0; image < 2; ++image) {
        const auto begin = images.begin() + static_cast<std::ptrdiff_t>(image * texels);
        const auto exact = reference::block_cosines(as_doubles({begin, begin + static_cast<std::ptrdiff_t>(texels)}),
                                                    static_cast<std::size_t>(width), static_cast<std::size_t>(height),
                                                    static_cast<std::size_t>(side));
        const auto first = found.begin() + static_cast<std::ptrdiff_t>(image * values / 2);
        add_all(image == 0 ? std::vector<float>(first, first + static_cast<std::ptrdiff_t>(values / 2))
                           : std::vector<float>(first, found.end()),
                exact, fmt::format("{} x {}, blocks of {}, image {}", width, height, side, image), worst);
      }
      const std::vector<float> behind = downloaded<float>(device, half_way);
      for (std::size_t i = values; i < behind.size(); ++i)
        worst.add(behind[i] == kLeftAlone ? 0.0 : 1.0, fmt::format("behind half-way values, {}", i));
    }
}

// Tests lines of 2 to 40 samples in two images with three lines each. Lines of fewer than five samples are mirrored
// several times.
void lines_shorter_than_filters(Device& device, WorstError& worst) {
  constexpr std::size_t kImages = 2, kLines = 3;
  SplitMix64 random(63);
  for (const std::size_t length : {2, 3, 4, 5, 6, 7, 8, 9, 40}) {
    const std::size_t texels = kLines * length;
    const std::vector<float> images = random_list(kImages * texels, random);
    const DeviceBuffer coefficients = uploaded(device, room_for(images.size()), "coefficients");
    transform_kernel(device, "wavelet_lift")
        .launch({kImages * kLines * ((length + 1) / 2), kItemsOfGroup}, uploaded(device, images, "images"),
                coefficients, static_cast<int>(kImages), static_cast<int>(texels), static_cast<int>(kLines),
                static_cast<int>(length), static_cast<int>(length), 1);
    std::vector<double> exact;
    for (std::size_t line = 0; line < kImages * kLines; ++line) {
      const auto begin = images.begin() + static_cast<std::ptrdiff_t>(line * length);
      const auto values = reference::wavelet_line(as_doubles({begin, begin + static_cast<std::ptrdiff_t>(length)}));
      exact.insert(exact.end(), values.begin(), values.end());
    }
    add_all(downloaded<float>(device, coefficients), exact, fmt::format("{} samples", length), worst);
  }
}

}  // namespace

std::vector<NumericalCase> transform_cases() {
  const std::string unit = "of the largest coefficient";
  return {
      {{"colours-near-grey", "colour_planes",
        "each colour difference contains the rounding errors of three colour values",
        "the kernel uses fused multiply-add instructions and adds the smallest product first", 2e-7,
        "of the largest value", "only three numbers are rounded, and none of them exceeds the largest value"},
       colours_near_grey,
       {},
       {},
       {{"image_transform", "fma(axes[4 * p + 1], green,", "fma(axes[4 * p], green,"}}},
      {{"blocks-beyond-borders", "dct_rows, dct_columns",
        "a block at the border of an image reads texels of the next image",
        "the kernel clamps coordinates to the image", 5e-7, unit, "each of two sums adds up to 32 rounded products"},
       blocks_beyond_borders,
       {{"image_transform", "samples[x] = row[min(left + x, width - 1)];", "samples[x] = row[left + x];"},
        {"image_transform", "y = min(block / columns * side + item % side, height - 1);",
         "y = block / columns * side + item % side;"}}},
      {{"lines-shorter-than-filters", "wavelet_lift",
        "in a line of fewer than five samples, an index can still be outside the line after it was mirrored",
        "the kernel first reduces each index modulo the period of the repeatedly mirrored line", 1e-6, unit,
        "each of the four lifting steps doubles the rounding error"},
       lines_shorter_than_filters,
       {{"image_transform", "i = i % period;", ""}}},
  };
}

}  // namespace multum
