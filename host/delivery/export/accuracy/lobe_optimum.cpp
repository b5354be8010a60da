// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/accuracy/lobe_optimum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <glm/geometric.hpp>

namespace multum {
namespace {

// The parameters of an isotropic lobe are log alpha, and x and y of the slope by which the normal is tilted. An
// anisotropic lobe also has log (wide / narrow) and the angle of the axis.
using Point = std::vector<double>;

GgxLobe lobe_at(const GgxLobe& start, const Point& p, double alpha_min) {
  const glm::dvec3 x = start.axis, y = glm::cross(start.normal, x);
  GgxLobe lobe;
  lobe.normal = glm::normalize(start.normal + p[0] * x + p[1] * y);
  const auto alpha = [&](double log_alpha) { return std::clamp(std::exp(log_alpha), alpha_min, 1.0); };
  const double ratio = p.size() > 3 ? p[3] : 0.0, angle = p.size() > 4 ? p[4] : 0.0;
  lobe.alpha_wide = alpha(p[2] + 0.5 * ratio);
  lobe.alpha_narrow = alpha(p[2] - 0.5 * ratio);
  const glm::dvec3 axis = std::cos(angle) * x + std::sin(angle) * y;
  lobe.axis = glm::normalize(axis - glm::dot(axis, lobe.normal) * lobe.normal);
  return lobe;
}

struct Vertex {
  Point point;
  double value;
};

// As in Nelder and Mead, the coefficient of reflection is 1, of expansion 2, and of contraction and shrinking 1/2.
Point least_point(const std::function<double(const Point&)>& value, const Point& start, const Point& steps,
                  int evaluations) {
  const std::size_t n = start.size();
  std::vector<Vertex> simplex = {{start, value(start)}};
  for (std::size_t k = 0; k < n; ++k) {
    Point point = start;
    point[k] += steps[k];
    simplex.push_back({point, value(point)});
  }
  const auto by_value = [](const Vertex& a, const Vertex& b) { return a.value < b.value; };
  for (int used = static_cast<int>(n) + 1; used < evaluations;) {
    std::sort(simplex.begin(), simplex.end(), by_value);
    Point middle(n, 0.0);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < n; ++k) middle[k] += simplex[i].point[k] / static_cast<double>(n);
    const auto along = [&](double factor) {
      Vertex vertex{middle, 0.0};
      for (std::size_t k = 0; k < n; ++k) vertex.point[k] += factor * (simplex[n].point[k] - middle[k]);
      vertex.value = value(vertex.point);
      ++used;
      return vertex;
    };
    Vertex next = along(-1.0);
    if (next.value < simplex[0].value) {
      Vertex further = along(-2.0);
      if (further.value < next.value) next = std::move(further);
    } else if (next.value >= simplex[n - 1].value) {
      next = along(next.value < simplex[n].value ? -0.5 : 0.5);
    }
    if (next.value < simplex[n].value) {
      simplex[n] = std::move(next);
      continue;
    }
    for (std::size_t i = 1; i <= n; ++i, ++used) {
      for (std::size_t k = 0; k < n; ++k) simplex[i].point[k] = 0.5 * (simplex[i].point[k] + simplex[0].point[k]);
      simplex[i].value = value(simplex[i].point);
    }
  }
  return std::min_element(simplex.begin(), simplex.end(), by_value)->point;
}

}  // namespace

GgxLobe find_lobe_optimum(const ReferenceLights& lights, const GgxLobe& start, bool is_anisotropic, double alpha_min) {
  const double wide = std::max(start.alpha_wide, alpha_min), narrow = std::max(start.alpha_narrow, alpha_min);
  const double middle = 0.5 * std::log(wide * narrow), step = 0.3 * std::sqrt(wide * narrow);
  Point point = {0.0, 0.0, middle}, steps = {step, step, 0.2};
  if (is_anisotropic) {
    point.insert(point.end(), {std::log(wide / narrow), 0.0});
    steps.insert(steps.end(), {0.4, 0.4});
  }
  const auto value = [&](const Point& p) {
    const LobeError found = error_of_lobe(lights, lobe_at(start, p, alpha_min));
    return found.error + std::abs(found.energy - 1.0);
  };
  // The search is restarted from its result, because a simplex that has become flat finds no further improvement.
  const int evaluations = is_anisotropic ? 160 : 80;
  for (int round = 0; round < 2; ++round) point = least_point(value, point, steps, evaluations);
  return lobe_at(start, point, alpha_min);
}

}  // namespace multum
