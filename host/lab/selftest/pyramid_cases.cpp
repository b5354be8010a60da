// SPDX-License-Identifier: Apache-2.0
// Tests the averages of every level (kernels/mip_box.cl) and reflectance maps (reflectance_pyramid.cl, Williams 1983).
// The inputs contain values that arithmetic would change, and sums over more texels than a float can count. Other
// inputs contain highlights that are narrower than a texel, and light along and behind the surface.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/bakes/pyramid/row_blocks.h"
#include "host/formats/asset/pyramid/reflectance_mapping.h"
#include "host/foundation/base/split_mix.h"
#include "host/lab/reference/reflectance.h"
#include "host/lab/selftest/box_launch.h"
#include "host/lab/selftest/buffers.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/em_launch.h"
#include "kernels/shared/mip_box.h"
#include "kernels/shared/reflectance.h"

namespace multum {
namespace {

constexpr std::size_t kLocal = 64;  // launch sizes are rounded up to a multiple of this number

MultumBoxBand band_of(int width, int rows, int planes, int row_length) {
  MultumBoxBand band{};
  band.map_width = width;
  band.map_height = band.row_count = rows;
  band.row_length = row_length;
  band.plane_count = planes;
  return band;
}

}  // namespace

std::vector<std::vector<float>> block_sums(Device& device, const RowBlocks& blocks,
                                           const std::vector<std::vector<float>>& rows) {
  const std::size_t row_length = blocks.node_count() + 5;
  std::vector<float> nodes(rows.size() * row_length, kPoison);
  for (std::size_t r = 0; r < rows.size(); ++r)
    std::copy(rows[r].begin(), rows[r].end(), nodes.begin() + static_cast<std::ptrdiff_t>(r * row_length));
  const DeviceBuffer buffer = uploaded(device, nodes, "nodes");
  const MultumBoxBand band =
      band_of(blocks.block_count(0), static_cast<int>(rows.size()), 1, static_cast<int>(row_length));
  Kernel kernel = device.kernel("mip_box", "mip_blocks", {1, 1, false});
  const auto begin = [&](int k) { return static_cast<int>(blocks.block_begin(k)); };
  for (int k = 1; k < blocks.depth(); ++k)
    kernel.launch({rows.size() * static_cast<std::size_t>(blocks.block_count(k)), kLocal}, buffer, band, begin(k - 1),
                  begin(k), blocks.block_count(k));
  nodes = downloaded<float>(device, buffer);
  std::vector<std::vector<float>> of_rows;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto first = nodes.begin() + static_cast<std::ptrdiff_t>(r * row_length);
    of_rows.emplace_back(first, first + static_cast<std::ptrdiff_t>(blocks.node_count()));
  }
  return of_rows;
}

namespace {

constexpr MultumBoxBand kOddBands[] = {
    {1, 1, 0, 1, 12, 1, 0, 0}, {37, 5, 0, 5, 48, 3, 0, 0}, {64, 1, 0, 1, 75, 8, 0, 0}, {1, 37, 0, 37, 9, 2, 0, 0}};

// Returns numbers that arithmetic can change: signed zeros, denormal numbers, the limits of the range, and NaN.
std::vector<float> odd_numbers(std::size_t count) {
  constexpr float kOdd[] = {0.0f,     -0.0f,   1e-45f,     -1e-40f,      0x1p-126f, 3.4028235e38f, -HUGE_VALF,
                            1.0f / 3, -1e-30f, 16777217.f, -16777216.0f, kPoison,   0.1f};
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = kOdd[i % std::size(kOdd)];
  return values;
}

std::string text_of(const MultumBoxBand& band) {
  return fmt::format("{} x {}, {} planes", band.map_width, band.row_count, band.plane_count);
}

constexpr float kUntouched = -12345.0f;

// Runs `fill` with a buffer of nodes that is large enough for the surplus work-items of a launch. Every texel must
// equal `expected(plane, row, column)` bit by bit, and the rest of the buffer must not change.
void add_nodes(Device& device, const MultumBoxBand& band,
               const std::function<void(const DeviceBuffer& nodes, std::size_t items)>& fill,
               const std::function<float(int plane, int row, int column)>& expected, WorstError& worst) {
  const auto row_length = static_cast<std::size_t>(band.row_length);
  const auto rows = static_cast<std::size_t>(band.plane_count * band.row_count);
  const DeviceBuffer nodes =
      uploaded(device, std::vector<float>((rows + kLocal + 1) * row_length, kUntouched), "nodes");
  fill(nodes, rows * static_cast<std::size_t>(band.map_width) + kLocal);
  const std::vector<float> found = downloaded<float>(device, nodes);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const int row = static_cast<int>(i / row_length), column = static_cast<int>(i % row_length);
    const bool is_texel = i < rows * row_length && column < band.map_width;
    const float value = is_texel ? expected(row / band.row_count, row % band.row_count, column) : kUntouched;
    worst.add(std::bit_cast<std::uint32_t>(found[i]) == std::bit_cast<std::uint32_t>(value) ? 0.0 : 1.0,
              fmt::format("{}, node {}", text_of(band), i));
  }
}

void texels_keep_their_bits(Device& device, WorstError& worst) {
  for (const MultumBoxBand& band : kOddBands) {
    std::vector<float> planes;
    add_nodes(
        device, band,
        [&](const DeviceBuffer& nodes, std::size_t items) {
          planes = odd_numbers(items);
          device.kernel("mip_box", "mip_texels", {1, 1, false})
              .launch({items - kLocal, kLocal}, uploaded(device, planes, "planes"), nodes, band);
        },
        [&](int plane, int row, int column) {
          return planes[static_cast<std::size_t>((plane * band.row_count + row) * band.map_width + column)];
        },
        worst);
  }
}

// Fills three planes that follow `kBefore` other planes, which must not change.
void features_keep_their_bits(Device& device, WorstError& worst) {
  constexpr int kBefore = 5;
  for (MultumBoxBand band : kOddBands) {
    band.plane_count = kBefore + 3;
    std::vector<float> values;
    const auto texels = static_cast<std::size_t>(band.row_count * band.map_width);
    add_nodes(
        device, band,
        [&](const DeviceBuffer& nodes, std::size_t items) {
          values = odd_numbers(items + 2);
          const auto from = [&](std::ptrdiff_t first) {
            return uploaded(device, std::vector<float>(values.begin() + first, values.end()), "values");
          };
          device.kernel("mip_box", "mip_features", {1, 1, false})
              .launch({texels, kLocal}, from(0), from(1), from(2), nodes, band, kBefore);
        },
        [&](int plane, int row, int column) {
          const int at = row * band.map_width + column + plane - kBefore;
          return plane < kBefore ? kUntouched : values[static_cast<std::size_t>(at)];
        },
        worst);
  }
}

// Returns several kinds of rows. They contain equal texels, texels with a contrast of 1e6 and both signs, denormal
// texels, and texels that are as large as their sum allows.
std::vector<std::vector<float>> rows_to_sum(int width) {
  SplitMix64 random(15);
  std::vector<std::vector<float>> rows(4, std::vector<float>(static_cast<std::size_t>(width)));
  for (std::size_t x = 0; x < rows[0].size(); ++x) {
    rows[0][x] = 0.1f;
    rows[1][x] = static_cast<float>(std::pow(10.0, -6.0 * random.uniform())) * (random.uniform() < 0.5 ? -1.0f : 1.0f);
    rows[2][x] = x % 3 == 0 ? -0.0f : 1e-40f;
    rows[3][x] = 1e34f;
  }
  return rows;
}

// Adds |found - exact sum|, divided by the sum of magnitudes. Devices are allowed to treat denormal values as 0.
void add_sum(double found, const float* begin, const float* end, const std::string& input, WorstError& worst) {
  double sum = 0.0, magnitude = 0.0;
  for (const float* x = begin; x != end; ++x) {
    sum += static_cast<double>(*x);
    magnitude += std::abs(static_cast<double>(*x));
  }
  worst.add(found, sum, std::max(magnitude, 0x1p-100), input);
}

void blocks_of_32768(Device& device, WorstError& worst) {
  for (const int width : {1, 2, 3, 37, 101, 1024, 32768}) {
    const RowBlocks blocks(width);
    const std::vector<std::vector<float>> rows = rows_to_sum(width);
    const std::vector<std::vector<float>> nodes = block_sums(device, blocks, rows);
    for (std::size_t r = 0; r < rows.size(); ++r)
      for (int k = 0; k < blocks.depth(); ++k)
        for (int i = 0; i < blocks.block_count(k); ++i)
          add_sum(static_cast<double>(nodes[r][blocks.block_begin(k) + static_cast<std::size_t>(i)]),
                  rows[r].data() + (std::size_t{1} << k) * static_cast<std::size_t>(i),
                  rows[r].data() + (std::size_t{1} << k) * static_cast<std::size_t>(i + 1),
                  fmt::format("{} wide, row {}, block {} of {}", width, r, i, 1 << k), worst);
  }
}

// Adds texels from left to right instead of in pairs.
void rows_from_left_to_right(WorstError& worst) {
  const std::vector<float> row = rows_to_sum(32768)[0];
  float sum = 0.0f;
  for (const float x : row) sum += x;
  add_sum(static_cast<double>(sum), row.data(), row.data() + row.size(), "equal texels", worst);
}

// Tests a map of 2^30 texels, which is the largest possible map. Each node is the sum of one row, and the coarsest
// level adds all nodes in one column.
void average_of_2_30(Device& device, WorstError& worst) {
  constexpr int kSide = 32768;
  SplitMix64 random(30);
  std::vector<float> rows(kSide);
  double exact = 0.0;
  for (float& row : rows) {
    row = static_cast<float>(kSide * (0.28 + 0.01 * random.uniform()));
    exact += static_cast<double>(row);
  }
  exact /= static_cast<double>(kSide) * kSide;
  MultumBoxBand band = band_of(kSide, kSide, 1, 1);
  band.level_count = band.column_count = 1;
  MultumBoxLevel level{};
  level.width = level.height = level.row_count = 1;
  level.share = 1.0f / (static_cast<float>(kSide) * static_cast<float>(kSide));
  DeviceBuffer sums = device.make_buffer(2 * sizeof(float), "sums");
  device.fill_zero(sums);
  const DeviceBuffer averages = uploaded(device, std::vector<float>{kPoison}, "averages");
  device.kernel("mip_box", "mip_levels", {1, 1, false})
      .launch({1}, uploaded(device, rows, "nodes"), uploaded(device, std::vector{level}, "levels"),
              uploaded(device, std::vector{0, 1}, "taps"), uploaded(device, std::vector{MultumBoxTap{0, 1.0f}}, "taps"),
              sums, averages, band);
  worst.add(static_cast<double>(downloaded<float>(device, averages)[0]), exact, exact, "32768 rows");
}

struct ReflectanceTest {
  int size, sample_side;
  double exponent;
  std::vector<reference::DistantLight> lights;
  glm::dvec3 diffuse{0.3, 0.5, 0.7}, specular{1.0, 0.5, 0.25};
};

glm::dvec3 as_floats(const glm::dvec3& v) { return glm::dvec3(glm::vec3(v)); }

MultumReflectanceLight device_light(const reference::DistantLight& light) {
  const glm::vec3 l(light.direction), h(glm::normalize(light.direction + glm::dvec3(0.0, 0.0, 1.0))),
      e(light.irradiance);
  return {l.x, l.y, l.z, 0.0f, h.x, h.y, h.z, 0.0f, e.x, e.y, e.z, 0.0f};
}

// Compares the rows of a reflectance map, starting with `first_row`, with the mean over all normals of each texel.
// Errors are relative to the brightest texel.
void add_reflectance(Device& device, const ReflectanceTest& test, int first_row, WorstError& worst) {
  std::vector<MultumReflectanceLight> lights;
  for (const reference::DistantLight& light : test.lights) lights.push_back(device_light(light));
  const glm::vec3 k_d(test.diffuse), k_s(test.specular);
  const MultumReflectanceMap map = {test.size,
                                    test.sample_side,
                                    static_cast<int>(lights.size()),
                                    static_cast<float>(test.exponent),
                                    k_d.x,
                                    k_d.y,
                                    k_d.z,
                                    0.0f,
                                    k_s.x,
                                    k_s.y,
                                    k_s.z,
                                    0.0f};
  MultumBoxBand band = band_of(test.size, test.size - first_row, 3, test.size + 3);
  band.map_height = test.size;
  band.first_row = first_row;
  const auto rows = static_cast<std::size_t>(3 * band.row_count), length = static_cast<std::size_t>(band.row_length);
  const DeviceBuffer nodes = uploaded(device, std::vector<float>(rows * length, kPoison), "nodes");
  device.kernel("reflectance_pyramid", "reflectance_texels", {1, 1, false})
      .launch({static_cast<std::size_t>(band.row_count * test.size), kLocal}, uploaded(device, lights, "lights"), nodes,
              map, band);
  const std::vector<float> found = downloaded<float>(device, nodes);
  const reference::PhongSurface surface = {test.exponent, as_floats(test.diffuse), as_floats(test.specular)};
  std::vector<glm::dvec3> exact;
  glm::dvec3 brightest(0.0);
  const int samples = test.size * test.sample_side;
  for (int y = first_row; y < test.size; ++y)
    for (int x = 0; x < test.size; ++x) {
      glm::dvec3 sum(0.0);
      for (int j = 0; j < test.sample_side; ++j)
        for (int i = 0; i < test.sample_side; ++i)
          sum += reference::phong_radiance(reflectance_normal({}, {(x * test.sample_side + i + 0.5) / samples,
                                                                   (y * test.sample_side + j + 0.5) / samples}),
                                           {0.0, 0.0, 1.0}, test.lights, surface);
      exact.push_back(sum / static_cast<double>(test.sample_side * test.sample_side));
      brightest = glm::max(brightest, exact.back());
    }
  for (std::size_t t = 0; t < exact.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t row = t / static_cast<std::size_t>(test.size), column = t % static_cast<std::size_t>(test.size);
      const std::size_t at = (c * static_cast<std::size_t>(band.row_count) + row) * length + column;
      const int channel = static_cast<int>(c);
      worst.add(static_cast<double>(found[at]), exact[t][channel], std::max(brightest[channel], 0x1p-100),
                fmt::format("{} x {} of {} x {} normals, s {}, texel {}, channel {}", test.size, test.size,
                            test.sample_side, test.sample_side, test.exponent, t, c));
    }
}

reference::DistantLight light_from(double degrees, double azimuth, const glm::dvec3& irradiance) {
  return {as_floats(tilted(degrees, azimuth)), as_floats(irradiance)};
}

void highlights_of_1e5(Device& device, WorstError& worst) {
  for (const double exponent : {1.0, 100.0, 1e4, 1e5})
    add_reflectance(device, {64, 8, exponent, {light_from(20.0, 0.4, glm::dvec3(1.0))}}, 16, worst);
}

// Tests a level of one texel and levels of odd sizes, with thousands of normals per texel and lights from 1e-6 to 1e6.
void normals_of_a_texel(Device& device, WorstError& worst) {
  const std::vector<reference::DistantLight> lights = {light_from(0.0, 0.0, {1e-6, 1.0, 1e6}),
                                                       light_from(40.0, 1.0, {1e6, 1e-6, 1.0}),
                                                       light_from(70.0, 4.0, {1.0, 1e6, 1e-6})};
  add_reflectance(device, {1, 128, 1.0, lights}, 0, worst);
  add_reflectance(device, {1, 1, 10.0, lights}, 0, worst);
  add_reflectance(device, {5, 32, 10.0, lights}, 2, worst);
}

// Tests a light along the surface and a light from behind. Only surfaces that face a light may be lit. A light from
// straight behind must have no effect.
void light_from_behind(Device& device, WorstError& worst) {
  for (const double degrees : {89.9, 90.0, 90.1, 179.0})
    for (const double exponent : {1.0, 50.0})
      add_reflectance(device, {9, 4, exponent, {light_from(degrees, 0.7, glm::dvec3(1.0))}}, 0, worst);
}

std::vector<NumericalCase> box_cases() {
  const std::string same = "wrong values", none = "the kernel only copies values, so they must not change";
  return {
      {{"texels-keep-their-bits", "mip_texels", "surplus work-items write beyond the end of the buffer",
        "the kernel checks the bounds first, and only copies values", kNothingWrong, same, none},
       texels_keep_their_bits,
       {{"mip_box", "if (item >= band.plane_count * band.row_count * band.map_width) return;", ""}}},
      {{"features-keep-their-bits", "mip_features", "surplus work-items write into the next plane",
        "the kernel checks the bounds first, and only copies values", kNothingWrong, same, none},
       features_keep_their_bits,
       {{"mip_box", "if (item >= band.row_count * band.map_width) return;", ""}}},
      {{"blocks-of-32768-texels", "mip_blocks",
        "if 32768 equal texels are added from left to right, every sum is rounded in the same direction",
        "the kernel adds texels in pairs, then adds the sums in pairs, and so on, so each texel is rounded only 15 "
        "times",
        1e-6, "of the sum of magnitudes", "15 rounding errors of 6e-8 add up to 9e-7"},
       blocks_of_32768,
       {},
       rows_from_left_to_right},
      {{"average-of-2-30-texels", "mip_levels",
        "the sum is rounded 32768 times, each time by half a unit in the last place",
        "the kernel adds the rows by compensated summation", 1.2e-7, "relative error",
        "only the share of each row and the result are rounded"},
       average_of_2_30,
       {{"mip_box", "      add_compensated(&sum, &carry, value);\n      continue;",
         "      sum += value;\n      continue;"}}},
  };
}

}  // namespace

std::vector<NumericalCase> pyramid_cases() {
  std::vector<NumericalCase> cases = box_cases();
  const auto add = [&](const char* name, const char* without, const char* guard, double bound, const char* reason,
                       void (*run)(Device&, WorstError&), const std::vector<SourceEdit>& edits) {
    cases.push_back(
        {{name, "reflectance_texels", without, guard, bound, "of the brightest texel", reason}, run, edits});
  };
  add("highlights-narrower-than-texels",
      "1 - n . h has a rounding error of 6e-8, which the highlight exponent s = 1e5 multiplies",
      "1 - n . h is computed as |n - h|^2 / 2", 2e-5,
      "the normal n and the half vector h have rounding errors of up to 6e-8, and |n - h| is only about 0.004 in a "
      "highlight with exponent 1e5",
      highlights_of_1e5,
      {{"reflectance_pyramid", "return 0.5f * fma(dx, dx, fma(dy, dy, dz * dz));",
        "return 1.0f - fma(dx + w.x, w.x, fma(dy + w.y, w.y, (dz + w.z) * w.z));"}});
  add("thousands-of-normals-a-texel", "49152 additions of similar numbers are rounded in the same direction",
      "sums are compensated", 5e-7,
      "only a few rounding errors remain per sample, no matter how many samples are added", normals_of_a_texel,
      {{"reflectance_pyramid", "const float total = *sum + value;",
        "*sum = *sum + value;\n  return;\n  const float total = *sum + value;"}});
  add("light-from-behind", "a light darkens surfaces that face away from it",
      "a light below the surface, with n . l <= 0, adds nothing", 1e-5,
      "the normal n and the half vector h have rounding errors of up to 6e-8, and |n - h| is about 0.2 in a highlight "
      "with exponent 50",
      light_from_behind, {{"reflectance_pyramid", "if (cosine <= 0.0f) continue;", ""}});
  return cases;
}

}  // namespace multum
