// SPDX-License-Identifier: Apache-2.0
// Compares points with all triangles by brute force, using bounding spheres. For 512 points and ten thousand triangles,
// this takes about ten milliseconds.
#include "host/fields/inference/mapping/camera_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/matrix.hpp>

#include "host/fields/inference/mapping/layer_segmentation.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr std::size_t kPixelsMax = 512;  // with this number, a measured share of 10 % has a standard deviation of 1.3 %
constexpr double kOffShareMax = 0.1;     // tolerates silhouettes, and geometry that is missing in the file

struct Triangle {
  glm::dvec3 a, b, c;
  glm::dvec3 centre;  // centre of the bounding sphere
  double radius;
};

std::vector<Triangle> placed_triangles(const std::vector<ObjectMesh>& objects, const AnimationSample& sample) {
  std::vector<Triangle> triangles;
  for (const ObjectMesh& object : objects) {
    const glm::dmat4& placement = object_place(object, sample.object_to_world);
    const auto corner = [&](std::size_t i) {
      return glm::dvec3(placement * glm::dvec4(glm::dvec3(object.positions[object.indices[i]]), 1.0));
    };
    for (std::size_t i = 0; i + 2 < object.indices.size(); i += 3) {
      Triangle t{corner(i), corner(i + 1), corner(i + 2), {}, 0.0};
      t.centre = (t.a + t.b + t.c) / 3.0;
      t.radius = std::max({glm::distance(t.centre, t.a), glm::distance(t.centre, t.b), glm::distance(t.centre, t.c)});
      triangles.push_back(t);
    }
  }
  return triangles;
}

double segment_distance(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const double length2 = glm::dot(b - a, b - a);
  const double t = length2 > 0.0 ? std::clamp(glm::dot(p - a, b - a) / length2, 0.0, 1.0) : 0.0;
  return glm::distance(p, a + t * (b - a));
}

// Returns the distance to the plane if the foot of the perpendicular is inside the triangle. Otherwise returns the
// distance to the nearest side.
double triangle_distance(const glm::dvec3& p, const Triangle& t) {
  const glm::dvec3 n = glm::cross(t.b - t.a, t.c - t.a);
  const bool is_inside = glm::dot(glm::cross(t.b - t.a, p - t.a), n) >= 0.0 &&
                         glm::dot(glm::cross(t.c - t.b, p - t.b), n) >= 0.0 &&
                         glm::dot(glm::cross(t.a - t.c, p - t.c), n) >= 0.0;
  const double area = glm::length(n);
  if (is_inside && area > 0.0) return std::abs(glm::dot(p - t.a, n)) / area;
  return std::min({segment_distance(p, t.a, t.b), segment_distance(p, t.b, t.c), segment_distance(p, t.c, t.a)});
}

double distance_to(const std::vector<Triangle>& triangles, const glm::dvec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Triangle& t : triangles)
    if (glm::distance(p, t.centre) - t.radius < nearest) nearest = std::min(nearest, triangle_distance(p, t));
  return nearest;
}

// Returns the depth of the far plane, or infinity if there is no such plane. If the last two rows of the projection are
// (0, 0, A, B) and (0, 0, -s, 0), then z equals w at a depth of B / (A + s).
double far_depth(const glm::dmat4& projection) {
  const double far = projection[3][2] / (projection[2][2] - projection[2][3]);
  return far > 0.0 && std::isfinite(far) ? far : std::numeric_limits<double>::infinity();
}

// Returns the camera-space point that is at `depth` along -z and projects to a pixel's centre.
glm::dvec3 camera_point(const glm::dmat4& projection, const glm::dvec2& ndc, double depth) {
  const double w = -projection[2][3] * depth;
  const glm::dvec2 fixed(projection[2][0] * -depth + projection[3][0], projection[2][1] * -depth + projection[3][1]);
  return glm::dvec3(glm::inverse(glm::dmat2(projection)) * (ndc * w - fixed), -depth);
}

// Returns an evenly spaced selection of the pixels that can be tested.
std::vector<std::size_t> tested_pixels(const std::vector<float>& depth, const std::vector<float>& coverage, double far,
                                       CameraCheck& check) {
  std::vector<std::size_t> usable, tested;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    check.nan_depths += std::isnan(depth[i]) ? 1 : 0;
    const bool is_covered = coverage.empty() || coverage[i] >= kWholeCoverage;
    if (is_covered && depth[i] > 0.0f && static_cast<double>(depth[i]) < far && std::isfinite(depth[i]))
      usable.push_back(i);
  }
  const std::size_t count = std::min(kPixelsMax, usable.size());
  for (std::size_t k = 0; k < count; ++k) tested.push_back(usable[k * usable.size() / count]);
  return tested;
}

}  // namespace

CameraCheck check_camera(const AnimationJob& job, const AnimationSample& sample, const std::vector<ObjectMesh>& objects,
                         const std::vector<float>& depth, const std::vector<float>& coverage) {
  const std::size_t pixel_count = static_cast<std::size_t>(job.width) * static_cast<std::size_t>(job.height);
  MULTUM_CHECK(depth.size() == pixel_count && (coverage.empty() || coverage.size() == pixel_count));
  const AnimationCamera& camera = job.cameras[static_cast<std::size_t>(sample.camera)];
  const glm::dmat4 camera_to_world = glm::inverse(camera.world_to_camera);
  const std::vector<Triangle> triangles = placed_triangles(objects, sample);
  CameraCheck check;
  std::vector<double> distances;
  for (const std::size_t i : tested_pixels(depth, coverage, far_depth(camera.projection), check)) {
    const auto x = static_cast<double>(i % static_cast<std::size_t>(job.width));
    const auto y = static_cast<double>(i / static_cast<std::size_t>(job.width));
    const glm::dvec2 ndc(2.0 * (x + 0.5) / job.width - 1.0, 1.0 - 2.0 * (y + 0.5) / job.height);
    const auto d = static_cast<double>(depth[i]);
    const glm::dvec4 point(camera_point(camera.projection, ndc, d), 1.0);
    distances.push_back(distance_to(triangles, glm::dvec3(camera_to_world * point)));
    check.off += distances.back() > job.depth_tolerance * d ? 1 : 0;
  }
  check.tested = static_cast<int>(distances.size());
  if (distances.empty()) return check;
  std::nth_element(distances.begin(), distances.begin() + std::ssize(distances) / 2, distances.end());
  check.distance_median = distances[distances.size() / 2];
  const double off_share = static_cast<double>(check.off) / check.tested;
  if (off_share > kOffShareMax)
    throw Error(
        ErrorCode::kInput,
        fmt::format("{}: sample {}: its depths do not match the objects in camera {}: {:.0f} % of {} pixels "
                    "differ by more than {} of their depth, and the median distance to the objects is {:.3g}; expected "
                    "at most {:.0f} %. Check the camera's matrices, depth, and the placement of objects",
                    job.path, sample.name, camera.name, 100.0 * off_share, check.tested, job.depth_tolerance,
                    check.distance_median, 100.0 * kOffShareMax));
  return check;
}

}  // namespace multum
