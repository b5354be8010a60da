// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/averages/moment_mipmap.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/formats/asset/half_value.h"
#include "host/formats/asset/lobes/gmm_quantize.h"
#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

// A variance below this fraction of the square of the mean counts as 0, because the rounding of floats can cause it.
// Rounding errors are 2^-24 at level 0, and a few times 2^-24 for averages.
constexpr double kVarianceZero = 1e-6;

// Returns E[b^2] computed about the rounded mean. If there is a variance, the result is rounded to nearest. Otherwise
// it is rounded down, so that readers clamp the variance to 0.
float rounded_square(float square, float mean, float rounded_mean) {
  const double exact_mean = static_cast<double>(mean), about = static_cast<double>(rounded_mean);
  const double variance = static_cast<double>(square) - exact_mean * exact_mean;
  if (variance <= kVarianceZero * exact_mean * exact_mean) return grid_below(about * about, StorageEncoding::kHalf);
  return as_half(static_cast<float>(variance + about * about));
}

void quantize_slopes(SlopeMoments& m) {
  const SlopeMoments exact = m;
  m.height = as_half(exact.height);
  m.s = as_half(exact.s);
  m.t = as_half(exact.t);
  m.ss = rounded_square(exact.ss, exact.s, m.s);
  m.tt = rounded_square(exact.tt, exact.t, m.t);
  const double covariance = static_cast<double>(exact.st) - static_cast<double>(exact.s) * static_cast<double>(exact.t);
  m.st = as_half(static_cast<float>(covariance + static_cast<double>(m.s) * static_cast<double>(m.t)));
}

// Rounds a single direction as in level 0 of lobes. x and y are rounded to nearest and z upwards, so the length stays
// 1.
bool quantize_direction(glm::vec3& n) {
  constexpr float kLengthSquaredOne = 1.0f - 1e-6f;
  if (glm::dot(n, n) < kLengthSquaredOne || n.z < 0.0f) return false;
  n.x = as_half(n.x);
  n.y = as_half(n.y);
  n.z = finest_z(n.x, n.y, StorageEncoding::kHalf);
  return true;
}

// Rounds single directions so that they remain single directions. Rounds all other normals like lobes of amplitude 1
// (host/formats/asset/lobes/movmf_quantize.cpp).
void quantize_normals(glm::vec3* normals, std::size_t count) {
  MovmfLevel lobe{0, 1, {{}}, {}};
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < count; ++i) {
    if (quantize_direction(normals[i])) continue;
    places.push_back(i);
    lobe.lobes[0].emplace_back(normals[i], 1.0f);
  }
  lobe.width = static_cast<int>(places.size());
  if (lobe.width == 0) return;
  quantize_movmf(lobe, StorageEncoding::kHalf, 1);
  for (std::size_t i = 0; i < places.size(); ++i) normals[places[i]] = glm::vec3(lobe.lobes[0][i]);
}

}  // namespace

std::vector<MomentLevel> empty_moment_levels(int width, int height) {
  std::vector<MomentLevel> levels;
  for (int l = 0; l < mip_level_count(width, height); ++l)
    levels.push_back({mip_level_size(width, l), mip_level_size(height, l), {}, {}, {}});
  return levels;
}

MomentLevel rows_of(const MomentLevel& level, int first_row, int row_count) {
  MULTUM_CHECK(first_row >= 0 && row_count >= 0 && first_row + row_count <= level.height);
  const auto width = static_cast<std::size_t>(level.width);
  const std::size_t all = width * static_cast<std::size_t>(level.height);
  const std::size_t first = width * static_cast<std::size_t>(first_row);
  const std::size_t end = first + width * static_cast<std::size_t>(row_count);
  const auto part_of = [&](const auto& values) { return texels_of(values, all, first, end); };
  return {level.width,           row_count, part_of(level.slopes), part_of(level.normals), part_of(level.colours),
          part_of(level.weights)};
}

void quantize_moments(MomentLevel& rows, StorageEncoding encoding, int threads) {
  MULTUM_CHECK(encoding != StorageEncoding::kSnorm16);
  if (encoding == StorageEncoding::kFloat) return;
  const auto width = static_cast<std::size_t>(rows.width);
  for_each_row_band(rows.height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
    const std::size_t end = static_cast<std::size_t>(row_end) * width;
    const std::size_t begin = static_cast<std::size_t>(row_begin) * width;
    quantize_normals(rows.normals.data() + begin, end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      quantize_slopes(rows.slopes[i]);
      if (!rows.colours.empty())
        for (int c = 0; c < 3; ++c) rows.colours[i][c] = as_half(rows.colours[i][c]);
    }
    const std::size_t weight_count = rows.weights.size() / rows.normals.size();
    for (std::size_t i = begin * weight_count; i < end * weight_count; ++i) rows.weights[i] = as_half(rows.weights[i]);
  });
}

float least_slope_deviation(StorageEncoding encoding) {
  // A rounding error of E[b^2] changes the variance by the same amount. Rounding to the nearest half causes an error of
  // at most 2^-11 of E[b^2]. A float average over a row of 32768 texels is rounded up to 15 times. Each rounding adds
  // at most 2^-24 of the sum. The rounding of the mean counts twice.
  constexpr double kQuarter = 0.25;
  const double moved = encoding == StorageEncoding::kHalf ? std::ldexp(1.0, -11) : std::ldexp(1.0, -19);
  return static_cast<float>(std::sqrt(moved / kQuarter));
}

}  // namespace multum
