// SPDX-License-Identifier: Apache-2.0
// Every quarter is size/2 texels wide (or size, if it fills the map). (x, y) are texel centres counted from its top
// left corner, with rows downwards. The second slope is used for y without a sign change, although rows grow downwards.
// As a surface, the map therefore has green down, and the statistics of a reader show this. The figures in
// docs/evidence/ACCURACY.md were measured with these values.
//   armour   unit hemispheres clipped at r^2 = 0.9025 (slope 3.04), rows shifted by half a period
//   rings    slope 1.2 sin(2 pi phase / 0.55) for phase < 0.55 of a wavelength of 16, along the radius
//   grooves  slope -1, +1, 0 for 40, 40, 20 % of a period of 12, along (cos 30, sin 30)
//   noise    host/formats/testmap/noise_quarter
// Here slope means n_xy / n_z.
#include "host/formats/testmap/four_quarter_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "host/formats/image/files/png_writer.h"
#include "host/formats/testmap/noise_quarter.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

using Rgb = std::array<double, 3>;

struct Texel {
  double slope_x;
  double slope_y;
  Rgb colour;
};

Rgb mix(const Rgb& one, const Rgb& zero, double t) {
  return {one[0] * t + zero[0] * (1 - t), one[1] * t + zero[1] * (1 - t), one[2] * t + zero[2] * (1 - t)};
}

double fraction(double v) { return v - std::floor(v); }

Texel armour_texel(double x, double y) {
  constexpr double kPeriod = 24.0;
  constexpr double kRadius2 = 0.9025;
  const double row = std::floor(y / kPeriod);
  const double u = fraction((x + std::fmod(row, 2.0) * kPeriod / 2.0) / kPeriod) * 2.0 - 1.0;
  const double v = fraction(y / kPeriod) * 2.0 - 1.0;
  const double z = std::sqrt(1.0 - std::min(u * u + v * v, kRadius2));
  const bool inside = u * u + v * v < kRadius2;
  const Rgb colour = mix({0.95, 0.75, 0.3}, {0.05, 0.1, 0.4}, (z - 0.3) / 0.7);
  return inside ? Texel{u / z, v / z, colour} : Texel{0.0, 0.0, colour};
}

Texel ring_texel(double x, double y, double quarter_size) {
  const double centre = quarter_size / 2.0 + 3.3;  // off the grid, so that all quadrants of the rings differ
  const double dx = x - centre;
  const double dy = y - centre;
  const double radius = std::sqrt(dx * dx + dy * dy) + 1e-3;
  const double phase = fraction(radius / 16.0);
  constexpr double kCut = 0.55;
  const bool cut = phase < kCut;
  const double slope = cut ? 1.2 * std::sin(2.0 * std::numbers::pi * phase / kCut) : 0.0;
  return {slope * dx / radius, slope * dy / radius, cut ? Rgb{0.8, 0.3, 0.2} : Rgb{0.4, 0.6, 0.8}};
}

Texel groove_texel(double x, double y) {
  const double cosine = std::cos(std::numbers::pi / 6.0);
  const double sine = std::sin(std::numbers::pi / 6.0);
  const double phase = fraction((x * cosine + y * sine) / 12.0);
  if (phase < 0.4) return {-cosine, -sine, {0.9, 0.1, 0.1}};
  if (phase < 0.8) return {cosine, sine, {0.1, 0.2, 0.9}};
  return {0.0, 0.0, {0.6, 0.6, 0.6}};
}

Texel noise_texel(const NoiseSlopes& slopes, int column) {
  const double slope_x = slopes.x[static_cast<std::size_t>(column)];
  const double slope_y = slopes.y[static_cast<std::size_t>(column)];
  return {slope_x, slope_y, mix({0.8, 0.8, 0.7}, {0.2, 0.3, 0.25}, std::clamp(0.5 + slope_x, 0.0, 1.0))};
}

std::uint16_t rounded_16_bit(double value) {
  return static_cast<std::uint16_t>(std::clamp(std::nearbyint(value * 65535.0), 0.0, 65535.0));
}

// Returns the normal that belongs to a slope, in 16 bits.
std::array<std::uint16_t, 3> normal_code(const Texel& texel) {
  const double z = 1.0 / std::sqrt(1.0 + texel.slope_x * texel.slope_x + texel.slope_y * texel.slope_y);
  return {rounded_16_bit(texel.slope_x * z * 0.5 + 0.5), rounded_16_bit(texel.slope_y * z * 0.5 + 0.5),
          rounded_16_bit(z * 0.5 + 0.5)};
}

// Decodes a normal in the same way as a reader of the PNG.
std::array<float, 3> unit_normal(const std::array<std::uint16_t, 3>& code) {
  std::array<double, 3> n;
  for (std::size_t c = 0; c < 3; ++c) n[c] = code[c] / 65535.0 * 2.0 - 1.0;
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  return {static_cast<float>(n[0] / length), static_cast<float>(n[1] / length), static_cast<float>(n[2] / length)};
}

// Makes rows of the map. A row has the codes of the normals in the PNG, and linear colours. Each has three values per
// texel.
struct FourQuarterRows {
  std::vector<std::uint16_t> normal_codes;
  std::vector<float> colours;
};

class FourQuarterGenerator {
 public:
  FourQuarterGenerator(int size, std::uint64_t seed, std::optional<Quarter> alone)
      : size_(size), quarter_size_(alone ? size : size / 2), alone_(alone), noise_(quarter_size_, seed) {
    MULTUM_CHECK(size >= 16 && size % 2 == 0);
  }

  // Makes the next rows. The noise quarter is made from the top.
  FourQuarterRows rows(int row_begin, int row_end) {
    std::vector<NoiseSlopes> noise;
    const int noise_begin = first_noise_row();
    for (int row = std::max(row_begin, noise_begin); row < row_end; ++row)
      noise.push_back(noise_.row(row - noise_begin));
    const std::size_t row_values = 3 * static_cast<std::size_t>(size_);
    FourQuarterRows rows;
    rows.normal_codes.resize(row_values * static_cast<std::size_t>(row_end - row_begin));
    rows.colours.resize(rows.normal_codes.size());
    for_each_item(row_end - row_begin, 0, [&](int i) {
      const int row = row_begin + i;
      const NoiseSlopes* slopes =
          row < noise_begin ? nullptr : &noise[static_cast<std::size_t>(row - std::max(row_begin, noise_begin))];
      const std::size_t first = static_cast<std::size_t>(i) * row_values;
      for (int column = 0; column < size_; ++column) {
        const Texel made = texel(column, row, slopes);
        const std::array<std::uint16_t, 3> code = normal_code(made);
        for (std::size_t c = 0; c < 3; ++c) {
          rows.normal_codes[first + 3 * static_cast<std::size_t>(column) + c] = code[c];
          rows.colours[first + 3 * static_cast<std::size_t>(column) + c] = static_cast<float>(made.colour[c]);
        }
      }
    });
    return rows;
  }

 private:
  Quarter quarter(int column, int row) const {
    if (alone_) return *alone_;
    const bool right = column >= quarter_size_;
    if (row < quarter_size_) return right ? Quarter::kRings : Quarter::kArmour;
    return right ? Quarter::kNoise : Quarter::kGrooves;
  }

  // Returns the first row that contains noise, or size_ if there is none.
  int first_noise_row() const {
    if (!alone_) return quarter_size_;
    return alone_ == Quarter::kNoise ? 0 : size_;
  }

  Texel texel(int column, int row, const NoiseSlopes* noise) const {
    const int quarter_column = column % quarter_size_;
    const double x = quarter_column + 0.5;
    const double y = row % quarter_size_ + 0.5;
    switch (quarter(column, row)) {
      case Quarter::kArmour: return armour_texel(x, y);
      case Quarter::kRings: return ring_texel(x, y, quarter_size_);
      case Quarter::kGrooves: return groove_texel(x, y);
      case Quarter::kNoise: return noise_texel(*noise, quarter_column);
    }
    return {};
  }

  int size_;
  int quarter_size_;
  std::optional<Quarter> alone_;
  NoiseQuarter noise_;
};

constexpr int kBandRows = 16;  // rows per band; 5 MB for rows of 16384 texels

}  // namespace

FourQuarterMap make_four_quarter_map(int size, std::uint64_t seed, std::optional<Quarter> alone) {
  FourQuarterGenerator generator(size, seed, alone);
  FourQuarterMap map;
  map.normals.width = map.normals.height = map.albedo.width = map.albedo.height = size;
  const std::size_t count = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  const std::array<std::vector<float>*, 3> normals = {&map.normals.x, &map.normals.y, &map.normals.z};
  const std::array<std::vector<float>*, 3> colours = {&map.albedo.r, &map.albedo.g, &map.albedo.b};
  for (std::size_t c = 0; c < 3; ++c) {
    normals[c]->reserve(count);
    colours[c]->reserve(count);
  }
  for (int row = 0; row < size; row += kBandRows) {
    const FourQuarterRows rows = generator.rows(row, std::min(size, row + kBandRows));
    for (std::size_t i = 0; i < rows.colours.size(); i += 3) {
      const std::array<float, 3> n =
          unit_normal({rows.normal_codes[i], rows.normal_codes[i + 1], rows.normal_codes[i + 2]});
      for (std::size_t c = 0; c < 3; ++c) {
        normals[c]->push_back(n[c]);
        colours[c]->push_back(rows.colours[i + c]);
      }
    }
  }
  map.normals.report.format = "generated, rounded to 16 bits";
  map.normals.report.encoding = "normal map, unsigned, green up (OpenGL), as requested";
  map.normals.report.encoding_reason = "every four-quarter map is generated with this encoding";
  return map;
}

void write_four_quarter_map(int size, std::uint64_t seed, const std::string& prefix, std::optional<Quarter> alone,
                            GreenAxis green) {
  FourQuarterGenerator generator(size, seed, alone);
  Png16Writer normals(prefix + "_normal.png", size, size, "Linear");
  Png16Writer albedo(prefix + "_albedo.png", size, size, "sRGB");
  for (int row = 0; row < size; row += kBandRows) {
    const int row_count = std::min(size - row, kBandRows);
    FourQuarterRows rows = generator.rows(row, row + row_count);
    if (green == GreenAxis::kUp)
      for (std::size_t i = 1; i < rows.normal_codes.size(); i += 3)
        rows.normal_codes[i] = static_cast<std::uint16_t>(65535 - rows.normal_codes[i]);
    const auto write_normals = [&] { normals.write_rows(row_count, rows.normal_codes.data()); };
    const auto write_albedo = [&] {
      std::vector<std::uint16_t> codes(rows.colours.size());
      for (std::size_t i = 0; i < codes.size(); ++i)
        codes[i] = rounded_16_bit(srgb_from_linear(static_cast<double>(rows.colours[i])));
      albedo.write_rows(row_count, codes.data());
    };
    for_each_item(2, 2, [&](int item) { item == 0 ? write_normals() : write_albedo(); });  // in parallel, because
                                                                                           // compression is slow
  }
  normals.finish();
  albedo.finish();
}

}  // namespace multum
