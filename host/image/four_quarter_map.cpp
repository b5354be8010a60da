// SPDX-License-Identifier: Apache-2.0
// Every quarter is size/2 texels wide; (x, y) are texel centres counted from its top left corner, rows downwards. The
// second slope is used as it stands for y, although rows grow downwards: the numbers are those that
// docs/ACCURACY.md was measured with, and as a surface they are one with green down. The statistics of a reader say so.
//   armour   unit hemispheres clipped at r^2 = 0.9025 (slope 3.04), rows shifted by half a period
//   rings    slope 1.2 sin(2 pi phase / 0.55) for phase < 0.55 of a wavelength of 16, along the radius
//   grooves  slope -1, +1, 0 for 40, 40, 20 % of a period of 12, along (cos 30, sin 30)
//   noise    white noise filtered by a Gaussian of 0.8 texels; slopes of central differences (the quarter is periodic),
//            scaled to rms 0.45, then by 0.4 .. 1.6 from left to right
// Here slope means n_xy / n_z. The noise is SplitMix64 and Box-Muller, written out, so that a seed means the same map
// under every standard library (up to the last bits of log, sin and cos, which rounding to 16 bits hides but for ties).
#include "host/image/four_quarter_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/base/error.h"
#include "host/base/split_mix.h"
#include "host/image/image_io.h"

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
  const double centre = quarter_size / 2.0 + 3.3;  // off the grid, so that no two quadrants of the rings are equal
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

// Box and Muller 1958; both numbers of a pair are used, in row order.
std::vector<double> white_noise(std::size_t count, std::uint64_t seed) {
  SplitMix64 generator(seed);
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; i += 2) {
    const double radius = std::sqrt(-2.0 * std::log(generator.uniform()));
    const double angle = 2.0 * std::numbers::pi * generator.uniform();
    values[i] = radius * std::cos(angle);
    if (i + 1 < count) values[i + 1] = radius * std::sin(angle);
  }
  return values;
}

// A square field that repeats.
struct PeriodicField {
  int size;
  std::vector<double> values;
  double at(int column, int row) const {
    const int x = ((column % size) + size) % size;
    const int y = ((row % size) + size) % size;
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x)];
  }
};

// Separable Gaussian of standard deviation 0.8 texels, cut at 6 texels, where it is 1e-12 of its middle.
PeriodicField gaussian_filtered(const PeriodicField& field) {
  constexpr int kRadius = 6;
  constexpr double kSigma = 0.8;
  std::array<double, 2 * kRadius + 1> weights;
  double sum = 0.0;
  for (int i = -kRadius; i <= kRadius; ++i)
    sum += weights[static_cast<std::size_t>(i + kRadius)] = std::exp(-0.5 * i * i / (kSigma * kSigma));
  for (double& weight : weights) weight /= sum;
  PeriodicField source = field;
  for (const bool horizontal : {true, false}) {
    PeriodicField target{field.size, std::vector<double>(field.values.size())};
    for (int row = 0; row < field.size; ++row) {
      for (int column = 0; column < field.size; ++column) {
        double value = 0.0;
        for (int i = -kRadius; i <= kRadius; ++i)
          value += weights[static_cast<std::size_t>(i + kRadius)] *
                   (horizontal ? source.at(column + i, row) : source.at(column, row + i));
        target.values[static_cast<std::size_t>(row) * static_cast<std::size_t>(field.size) +
                      static_cast<std::size_t>(column)] = value;
      }
    }
    source = std::move(target);
  }
  return source;
}

class NoiseQuarter {
 public:
  NoiseQuarter(int size, std::uint64_t seed)
      : field_(gaussian_filtered(
            {size, white_noise(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), seed)})) {
    double square_sum = 0.0;
    for (int row = 0; row < size; ++row)
      for (int column = 0; column < size; ++column) square_sum += difference_x(column, row) * difference_x(column, row);
    scale_ = 0.45 / std::sqrt(square_sum / (static_cast<double>(size) * size));
  }
  Texel texel(int column, int row) const {
    const double gain = scale_ * (0.4 + 1.2 * (column + 0.5) / field_.size);
    const double slope_x = gain * difference_x(column, row);
    const double slope_y = gain * (field_.at(column, row + 1) - field_.at(column, row - 1));
    return {slope_x, slope_y, mix({0.8, 0.8, 0.7}, {0.2, 0.3, 0.25}, std::clamp(0.5 + slope_x, 0.0, 1.0))};
  }

 private:
  double difference_x(int column, int row) const { return field_.at(column + 1, row) - field_.at(column - 1, row); }
  PeriodicField field_;
  double scale_ = 1.0;
};

std::uint16_t rounded_16_bit(double value) {
  return static_cast<std::uint16_t>(std::clamp(std::nearbyint(value * 65535.0), 0.0, 65535.0));
}

// The normal of a slope in 16 bits.
std::array<std::uint16_t, 3> normal_code(const Texel& texel) {
  const double z = 1.0 / std::sqrt(1.0 + texel.slope_x * texel.slope_x + texel.slope_y * texel.slope_y);
  return {rounded_16_bit(texel.slope_x * z * 0.5 + 0.5), rounded_16_bit(texel.slope_y * z * 0.5 + 0.5),
          rounded_16_bit(z * 0.5 + 0.5)};
}

// As a reader of the PNG decodes it.
std::array<float, 3> unit_normal(const std::array<std::uint16_t, 3>& code) {
  std::array<double, 3> n;
  for (std::size_t c = 0; c < 3; ++c) n[c] = code[c] / 65535.0 * 2.0 - 1.0;
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  return {static_cast<float>(n[0] / length), static_cast<float>(n[1] / length), static_cast<float>(n[2] / length)};
}

}  // namespace

FourQuarterMap make_four_quarter_map(int size, std::uint64_t seed) {
  MULTUM_CHECK(size >= 16 && size % 2 == 0);
  const int half = size / 2;
  const NoiseQuarter noise(half, seed);
  FourQuarterMap map;
  map.normals.width = map.normals.height = map.albedo.width = map.albedo.height = size;
  const std::size_t count = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  for (std::vector<float>* plane :
       {&map.normals.x, &map.normals.y, &map.normals.z, &map.albedo.r, &map.albedo.g, &map.albedo.b})
    plane->resize(count);
  map.normal_codes.reserve(3 * count);
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const double x = column % half + 0.5;
      const double y = row % half + 0.5;
      const bool right = column >= half;
      const Texel texel = row < half ? (right ? ring_texel(x, y, half) : armour_texel(x, y))
                                     : (right ? noise.texel(column - half, row - half) : groove_texel(x, y));
      const std::array<std::uint16_t, 3> code = normal_code(texel);
      map.normal_codes.insert(map.normal_codes.end(), code.begin(), code.end());
      const std::array<float, 3> n = unit_normal(code);
      const std::size_t i =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(size) + static_cast<std::size_t>(column);
      map.normals.x[i] = n[0];
      map.normals.y[i] = n[1];
      map.normals.z[i] = n[2];
      map.albedo.r[i] = static_cast<float>(texel.colour[0]);
      map.albedo.g[i] = static_cast<float>(texel.colour[1]);
      map.albedo.b[i] = static_cast<float>(texel.colour[2]);
    }
  }
  map.normals.report.format = "generated, rounded to 16 bits";
  map.normals.report.encoding = "normal map, unsigned, green up (OpenGL), as asked for";
  map.normals.report.encoding_reason = "the four-quarter map is made so";
  return map;
}

void write_four_quarter_map(const FourQuarterMap& map, const std::string& prefix) {
  const std::size_t count = map.albedo.r.size();
  std::vector<std::uint16_t> albedo(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<float, 3> colour = {map.albedo.r[i], map.albedo.g[i], map.albedo.b[i]};
    for (std::size_t c = 0; c < 3; ++c)
      albedo[3 * i + c] = rounded_16_bit(srgb_from_linear(static_cast<double>(colour[c])));
  }
  write_png16(prefix + "_normal.png", map.normals.width, map.normals.height, map.normal_codes, "Linear");
  write_png16(prefix + "_albedo.png", map.albedo.width, map.albedo.height, albedo, "sRGB");
}

}  // namespace multum
