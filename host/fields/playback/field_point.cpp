// SPDX-License-Identifier: Apache-2.0
#include "host/fields/playback/field_point.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <optional>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

std::size_t floor_index(const SampleGrid& grid, const std::vector<double>& point, std::size_t d) {
  return std::min(static_cast<std::size_t>(point[d]), grid.sizes[d] - 1);
}

std::size_t sample_of(const SampleGrid& grid, const std::vector<std::size_t>& at) {
  return grid.sample_at[grid.position_of(std::vector<int>(at.begin(), at.end()))];
}

/// A linear map that is a rotation whose columns are multiplied by these lengths.
struct TurnedSizes {
  glm::dquat turn{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 sizes{1.0};
};

std::optional<TurnedSizes> turned_sizes(const glm::dmat3& m) {
  TurnedSizes parts;
  glm::dmat3 axes(0.0);
  for (int c = 0; c < 3; ++c) {
    parts.sizes[c] = glm::length(m[c]);
    if (!(parts.sizes[c] > 0.0) || !std::isfinite(parts.sizes[c])) return {};
    axes[c] = m[c] / parts.sizes[c];
  }
  if (glm::determinant(axes) < 0.0) {  // a mirrored object gets one negative size
    parts.sizes.x = -parts.sizes.x;
    axes[0] = -axes[0];
  }
  constexpr double kSquare = 1e-4;  // matrices in files have single precision
  if (std::abs(glm::dot(axes[0], axes[1])) > kSquare || std::abs(glm::dot(axes[0], axes[2])) > kSquare ||
      std::abs(glm::dot(axes[1], axes[2])) > kSquare)
    return {};
  parts.turn = glm::quat_cast(axes);
  return parts;
}

glm::dquat turn_between(const glm::dquat& from, const glm::dquat& to, double share) {
  return glm::slerp(from, to, share);  // along the shorter arc
}

glm::dmat4 linear_between(const glm::dmat4& from, const glm::dmat4& to, double share) {
  return from * (1.0 - share) + to * share;
}

/// world_to_clip = projection * (turn, -turn eye). The projection of camera space, which looks along -z:
///      x_scale    0     x_shift  0
///         0    y_scale  y_shift  0
///         0       0     z_scale  z_offset
///         0       0       -w     0
struct CameraParts {
  glm::dquat turn{1.0, 0.0, 0.0, 0.0};  // world to camera
  glm::dvec3 eye{0.0};
  double x_scale = 1.0, x_shift = 0.0, y_scale = 1.0, y_shift = 0.0, z_scale = 0.0, z_offset = 0.0, w = 1.0;
};

std::optional<CameraParts> camera_parts(const glm::dmat4& world_to_clip) {
  const glm::dmat4 rows = glm::transpose(world_to_clip);
  const glm::dvec3 last(rows[3]), first(rows[0]), second(rows[1]), third(rows[2]);
  CameraParts parts;
  parts.w = glm::length(last);
  if (!(parts.w > 0.0)) return {};
  const glm::dvec3 z = -last / parts.w;
  parts.x_shift = glm::dot(first, z);
  parts.y_shift = glm::dot(second, z);
  const glm::dvec3 x = first - parts.x_shift * z, y = second - parts.y_shift * z;
  parts.x_scale = glm::length(x);
  parts.y_scale = glm::length(y);
  parts.z_scale = glm::dot(third, z);
  constexpr double kSquare = 1e-4;
  if (!(parts.x_scale > 0.0) || !(parts.y_scale > 0.0) ||
      std::abs(glm::dot(x, y)) > kSquare * parts.x_scale * parts.y_scale ||
      glm::length(third - parts.z_scale * z) > kSquare * (std::abs(parts.z_scale) + parts.w) ||
      glm::dot(glm::cross(x, y), z) < 0.0)
    return {};
  // The translation in camera space, computed from the rows: last.w = -w t.z, first.w = x_scale t.x + x_shift t.z, and
  // so on.
  glm::dvec3 shift;
  shift.z = -rows[3].w / parts.w;
  shift.x = (rows[0].w - parts.x_shift * shift.z) / parts.x_scale;
  shift.y = (rows[1].w - parts.y_shift * shift.z) / parts.y_scale;
  parts.z_offset = rows[2].w - parts.z_scale * shift.z;
  const glm::dmat3 world_to_camera = glm::transpose(glm::dmat3(x / parts.x_scale, y / parts.y_scale, z));
  parts.turn = glm::normalize(glm::quat_cast(world_to_camera));
  parts.eye = glm::conjugate(parts.turn) * -shift;
  return parts;
}

glm::dmat4 world_to_clip_of(const CameraParts& parts) {
  glm::dmat4 projection(0.0);
  projection[0][0] = parts.x_scale;
  projection[2][0] = parts.x_shift;
  projection[1][1] = parts.y_scale;
  projection[2][1] = parts.y_shift;
  projection[2][2] = parts.z_scale;
  projection[3][2] = parts.z_offset;
  projection[2][3] = -parts.w;
  glm::dmat4 world_to_camera(glm::mat3_cast(parts.turn));
  world_to_camera[3] = glm::dvec4(-(parts.turn * parts.eye), 1.0);
  return projection * world_to_camera;
}

}  // namespace

std::vector<double> clamped_point(const SampleGrid& grid, std::vector<double> point) {
  MULTUM_CHECK(point.size() == grid.sizes.size());
  for (std::size_t d = 0; d < point.size(); ++d)
    point[d] = std::clamp(point[d], 0.0, static_cast<double>(grid.sizes[d] - 1));
  return point;
}

std::size_t nearest_sample(const SampleGrid& grid, const std::vector<double>& point) {
  std::vector<std::size_t> at;
  for (std::size_t d = 0; d < point.size(); ++d)
    at.push_back(std::min(static_cast<std::size_t>(point[d] + 0.5), grid.sizes[d] - 1));
  return sample_of(grid, at);
}

std::vector<SampleShare> sample_shares(const SampleGrid& grid, const std::vector<double>& point, bool linear) {
  const std::size_t nearest = nearest_sample(grid, point);
  if (!linear) return {{nearest, 1.0f}};
  std::vector<std::pair<std::vector<std::size_t>, double>> corners = {{{}, 1.0}};
  for (std::size_t d = 0; d < point.size(); ++d) {
    const std::size_t low = floor_index(grid, point, d);
    const double share = point[d] - static_cast<double>(low);
    std::vector<std::pair<std::vector<std::size_t>, double>> next;
    for (const auto& [at, weight] : corners)
      for (const std::size_t step : {std::size_t{0}, std::size_t{1}}) {
        const double part = step == 0 ? 1.0 - share : share;
        if (part <= 0.0) continue;
        next.emplace_back(at, weight * part);
        next.back().first.push_back(low + step);
      }
    corners = std::move(next);
  }
  std::vector<SampleShare> shares;
  for (const auto& [at, weight] : corners) shares.push_back({sample_of(grid, at), static_cast<float>(weight)});
  std::stable_partition(shares.begin(), shares.end(), [&](const SampleShare& s) { return s.sample == nearest; });
  return shares;
}

glm::dmat4 place_between(const glm::dmat4& from, const glm::dmat4& to, double share) {
  const auto first = turned_sizes(glm::dmat3(from)), last = turned_sizes(glm::dmat3(to));
  if (!first || !last) return linear_between(from, to, share);
  const glm::dmat3 turn = glm::mat3_cast(turn_between(first->turn, last->turn, share));
  const glm::dvec3 sizes = glm::mix(first->sizes, last->sizes, share);
  glm::dmat4 place(glm::dmat3(turn[0] * sizes.x, turn[1] * sizes.y, turn[2] * sizes.z));
  place[3] = glm::mix(from[3], to[3], share);
  return place;
}

glm::dmat4 camera_between(const glm::dmat4& from, const glm::dmat4& to, double share) {
  const auto first = camera_parts(from), last = camera_parts(to);
  if (!first || !last) return linear_between(from, to, share);
  const auto mixed = [&](double CameraParts::*member) { return glm::mix((*first).*member, (*last).*member, share); };
  CameraParts parts;
  parts.turn = turn_between(first->turn, last->turn, share);
  parts.eye = glm::mix(first->eye, last->eye, share);
  parts.x_scale = mixed(&CameraParts::x_scale);
  parts.x_shift = mixed(&CameraParts::x_shift);
  parts.y_scale = mixed(&CameraParts::y_scale);
  parts.y_shift = mixed(&CameraParts::y_shift);
  parts.z_scale = mixed(&CameraParts::z_scale);
  parts.z_offset = mixed(&CameraParts::z_offset);
  parts.w = mixed(&CameraParts::w);
  return world_to_clip_of(parts);
}

glm::dmat4 matrix_at(const SampleGrid& grid, const std::vector<double>& point,
                     const std::function<glm::dmat4(std::size_t sample)>& of_sample, MatrixBetween between) {
  std::vector<std::size_t> at;
  const std::function<glm::dmat4(std::size_t)> along = [&](std::size_t d) -> glm::dmat4 {
    if (d == point.size()) return of_sample(sample_of(grid, at));
    const std::size_t low = floor_index(grid, point, d);
    const double share = point[d] - static_cast<double>(low);
    at.push_back(low);
    glm::dmat4 result = along(d + 1);
    if (share > 0.0) {
      ++at.back();
      const glm::dmat4 next = along(d + 1);
      if (next != result) result = between(result, next, share);  // most parameters move nothing
    }
    at.pop_back();
    return result;
  };
  return along(0);
}

}  // namespace multum
