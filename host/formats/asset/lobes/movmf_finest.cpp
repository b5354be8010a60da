// SPDX-License-Identifier: Apache-2.0
// Derives level 0 from x and y. z is rounded up, so that |(x, y, z)| >= 1. A texel of one direction then has no spread.
// Filtered texels that share the direction have no spread either, because their projections add up
// (host/formats/asset/lobes/movmf_quantize.cpp).
//
// A small z is ill-conditioned. If a normal is tilted by t, an error of x along the tilt turns the normal by 1/cos(t)
// times the error. The test FinestTest.TurnsDirectionsByLittle contains the figures.
#include "host/formats/asset/lobes/movmf_finest.h"

#include <half.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "host/formats/asset/half_value.h"
#include "host/formats/asset/lobes/gmm_quantize.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/asset/lobes/lobe_rounding.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {
namespace {

// |x| is at most 1, so the sum stays in range.
int nearest_step(float x) {
  const double steps = static_cast<double>(x) * kSnormSteps;
  return static_cast<int>(steps + (steps < 0.0 ? -0.5 : 0.5));
}

float step_value(int step) { return static_cast<float>(step / static_cast<double>(kSnormSteps)); }

// Returns exactly the smallest k with i^2 + j^2 + k^2 >= 32767^2. The root can safely be computed in double precision,
// because the root of a non-square integer below 2^30 differs by more than 2^-17 from every integer.
float z_snorm(float x, float y) {
  const int i = nearest_step(x), j = nearest_step(y);
  const int rest = std::max(kSnormSteps * kSnormSteps - i * i - j * j, 0);
  const double root = std::sqrt(static_cast<double>(rest));
  const int below = static_cast<int>(root);
  return step_value(below < root ? below + 1 : below);
}

// Returns exactly the smallest half with x^2 + y^2 + z^2 >= 1 if x and y are 16-bit floats. Every term is a multiple of
// 2^-48, so the doubles are exact. A root that is not a half differs from every half by at least 2^-49.
float z_half(double root) {
  half z(static_cast<float>(root));
  if (static_cast<double>(static_cast<float>(z)) < root) z.setBits(static_cast<unsigned short>(z.bits() + 1));
  return static_cast<float>(z);
}

float z_float(double root) {
  const auto z = static_cast<float>(root);
  return static_cast<double>(z) < root ? std::nextafter(z, 2.0f) : z;
}

// Returns whether x^2 + y^2 exceeds 1. The computation is exact, in whole steps.
bool is_beyond_rim(float x, float y) {
  const int i = nearest_step(x), j = nearest_step(y);
  return i * i + j * j > kSnormSteps * kSnormSteps;
}

void quantize_plane(glm::vec3& n, StorageEncoding encoding) {
  for (int c = 0; c < 2; ++c) {
    const float exact = std::clamp(n[c], -1.0f, 1.0f);
    if (encoding == StorageEncoding::kSnorm16) n[c] = step_value(nearest_step(exact));
    else n[c] = encoding == StorageEncoding::kHalf ? as_half(exact) : exact;
  }
}

// Rounds x, y and z of many unit vectors without branches. Vector instructions can round a small negative value to -0,
// where scalar code gives 0. Adding 0 makes both equal.
MULTUM_VECTOR_CLONES
void quantize_directions_snorm(glm::vec3* normals, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const float x = step_value(nearest_step(std::clamp(normals[i].x, -1.0f, 1.0f)));
    const float y = step_value(nearest_step(std::clamp(normals[i].y, -1.0f, 1.0f)));
    normals[i] = {x + 0.0f, y + 0.0f, z_snorm(x, y)};
  }
}

// Rounds lobes of amplitude 1 in the same way as in other levels.
void quantize_lobes_of_one(glm::vec3* normals, std::size_t count, const LobeFamily& family, StorageEncoding encoding) {
  MovmfLevel lobe{static_cast<int>(count), 1, {{}}, {}};
  for (std::size_t i = 0; i < count; ++i) lobe.lobes[0].emplace_back(normals[i], 1.0f);
  family.quantize(lobe, encoding, 1);
  for (std::size_t i = 0; i < count; ++i) normals[i] = glm::vec3(lobe.lobes[0][i]);
}

void quantize_texels(MovmfFinest& rows, std::size_t begin, std::size_t end, StorageEncoding encoding) {
  const LobeFamily& family = lobe_family(rows.representation);
  if (rows.has_roughness) quantize_lobes_of_one(rows.normals.data() + begin, end - begin, family, encoding);
  else family.quantize_finest(rows.normals.data() + begin, end - begin, encoding);
  if (encoding == StorageEncoding::kFloat) return;
  for (std::size_t i = begin; i < end && !rows.colours.empty(); ++i)
    for (int c = 0; c < 3; ++c) rows.colours[i][c] = as_half(rows.colours[i][c]);
  for (std::size_t i = begin * rows.weight_count(); i < end * rows.weight_count(); ++i)
    rows.weights[i] = as_half(rows.weights[i]);
}

// Rounding to 16-bit floats lengthens each channel by at most one step of 1/1024.
constexpr float kLengthSquaredMax = 1.01f, kLengthSquaredMin = 0.99f;

}  // namespace

float finest_z(float x, float y, StorageEncoding encoding) {
  if (encoding == StorageEncoding::kSnorm16) return z_snorm(x, y);
  const auto wide_x = static_cast<double>(x), wide_y = static_cast<double>(y);
  const double root = std::sqrt(std::max(0.0, 1.0 - wide_x * wide_x - wide_y * wide_y));
  return encoding == StorageEncoding::kHalf ? z_half(root) : z_float(root);
}

float finest_square(float x, float y, StorageEncoding encoding) {
  if (encoding == StorageEncoding::kSnorm16) {
    const int i = nearest_step(x), j = nearest_step(y);
    return step_value(std::min((i * i + j * j) / kSnormSteps, kSnormSteps));  // computed exactly
  }
  const auto wide_x = static_cast<double>(x), wide_y = static_cast<double>(y);
  return grid_below(wide_x * wide_x + wide_y * wide_y, encoding);
}

void quantize_unit_vectors(glm::vec3* normals, std::size_t count, StorageEncoding encoding) {
  if (encoding == StorageEncoding::kSnorm16) return quantize_directions_snorm(normals, count);
  for (std::size_t i = 0; i < count; ++i) {
    quantize_plane(normals[i], encoding);
    normals[i].z = finest_z(normals[i].x, normals[i].y, encoding);
  }
}

// The third value is x^2 + y^2, and snorm16 cannot store more than 1. Beyond the rim, x and y are therefore rounded
// inwards, as in other levels (gmm_quantize.cpp).
void quantize_points(glm::vec3* points, std::size_t count, StorageEncoding encoding) {
  for (std::size_t i = 0; i < count; ++i) {
    glm::vec3& point = points[i];
    const glm::vec2 exact(std::clamp(point.x, -1.0f, 1.0f), std::clamp(point.y, -1.0f, 1.0f));
    quantize_plane(point, encoding);
    if (encoding == StorageEncoding::kSnorm16 && is_beyond_rim(point.x, point.y))
      for (int c = 0; c < 2; ++c) point[c] = step_value(static_cast<int>(static_cast<double>(exact[c]) * kSnormSteps));
    point.z = finest_square(point.x, point.y, encoding);
  }
}

bool is_unit_vector(const glm::vec3& normal, bool has_roughness) {
  const float length_squared = glm::dot(normal, normal);
  return normal.z >= 0.0f && (has_roughness || length_squared >= kLengthSquaredMin) &&
         length_squared <= kLengthSquaredMax;
}

bool is_single_point(const glm::vec3& point, bool has_roughness) {
  const float scatter = point.z - point.x * point.x - point.y * point.y;
  return scatter >= kLengthSquaredMin - 1.0f && (has_roughness || scatter <= kLengthSquaredMax - 1.0f) &&
         point.z <= kLengthSquaredMax;
}

void quantize_movmf(MovmfFinest& rows, StorageEncoding encoding, int threads) {
  const auto width = static_cast<std::size_t>(rows.width);
  for_each_row_band(rows.height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
    quantize_texels(rows, static_cast<std::size_t>(row_begin) * width, static_cast<std::size_t>(row_end) * width,
                    encoding);
  });
}

MovmfFinest finest_of(const MovmfLevel& level, int first_row, int row_count, Representation representation,
                      bool has_roughness) {
  MULTUM_CHECK(first_row >= 0 && row_count >= 0 && first_row + row_count <= level.height);
  MULTUM_CHECK(!level.lobes.empty() && level.lobes.size() <= kLobeCountMax);
  const auto width = static_cast<std::size_t>(level.width);
  const std::size_t first = static_cast<std::size_t>(first_row) * width;
  const std::size_t texels = static_cast<std::size_t>(row_count) * width;
  const LobeFamily& family = lobe_family(representation);
  MovmfFinest rows{level.width, row_count, {}, {}, {}, {}, representation, has_roughness};
  rows.normals.resize(texels);
  rows.lobe.assign(texels, kLobeCountMax);
  if (!level.colours.empty()) rows.colours.resize(texels);
  const std::size_t weight_count =
      level.weights.empty() ? 0 : level.weights[0].size() / (width * static_cast<std::size_t>(level.height));
  rows.weights.resize(texels * weight_count);
  for (std::size_t j = 0; j < level.lobes.size(); ++j)
    for (std::size_t i = 0; i < texels; ++i) {
      const glm::vec4& lobe = level.lobes[j][first + i];
      const glm::vec3 colour = level.colours.empty() ? glm::vec3(0.0f) : level.colours[j][first + i];
      if (lobe == glm::vec4(0.0f) && colour == glm::vec3(0.0f)) continue;
      const glm::vec3 normal(lobe);
      const bool whole = lobe.w == 1.0f && family.is_single_direction(normal, has_roughness);
      const bool alone = rows.lobe[i] == kLobeCountMax;
      MULTUM_CHECK(whole && alone);
      rows.normals[i] = normal;
      rows.lobe[i] = static_cast<std::uint8_t>(j);
      if (!rows.colours.empty()) rows.colours[i] = colour;
      if (weight_count > 0)
        std::copy_n(&level.weights[j][(first + i) * weight_count], weight_count, &rows.weights[i * weight_count]);
    }
  const bool all_given = std::find(rows.lobe.begin(), rows.lobe.end(), kLobeCountMax) == rows.lobe.end();
  MULTUM_CHECK(all_given);
  return rows;
}

void expand_into(const MovmfFinest& rows, MovmfLevel& level, int first_row, int threads) {
  const auto width = static_cast<std::size_t>(rows.width);
  const std::size_t first = static_cast<std::size_t>(first_row) * width;
  const std::size_t weight_count = rows.weight_count();
  for_each_row_band(rows.height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
    const std::size_t end = static_cast<std::size_t>(row_end) * width;
    for (std::size_t j = 0; j < level.lobes.size(); ++j)
      for (std::size_t i = static_cast<std::size_t>(row_begin) * width; i < end; ++i) {
        const bool given = rows.lobe[i] == j;
        level.lobes[j][first + i] = given ? glm::vec4(rows.normals[i], 1.0f) : glm::vec4(0.0f);
        if (!level.colours.empty()) level.colours[j][first + i] = given ? rows.colours[i] : glm::vec3(0.0f);
        for (std::size_t k = 0; k < weight_count; ++k)
          level.weights[j][(first + i) * weight_count + k] = given ? rows.weights[i * weight_count + k] : 0.0f;
      }
  });
}

MovmfLevel expand(const MovmfFinest& rows, int lobe_count) {
  MovmfLevel level;
  level.width = rows.width;
  level.height = rows.height;
  const auto count = static_cast<std::size_t>(lobe_count);
  level.lobes.assign(count, std::vector<glm::vec4>(rows.normals.size()));
  if (!rows.colours.empty()) level.colours.assign(count, std::vector<glm::vec3>(rows.normals.size()));
  if (!rows.weights.empty()) level.weights.assign(count, std::vector<float>(rows.weights.size()));
  expand_into(rows, level, 0, 1);
  return level;
}

}  // namespace multum
