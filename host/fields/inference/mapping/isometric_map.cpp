// SPDX-License-Identifier: Apache-2.0
// With e the edge in texture coordinates, l = |R e|, s its length on the screen, eq. 7 is
//     f(R) = sum W g(l),   g(l) = ((l - s) / min(s, l))^2 = (l / s - 1)^2 for l >= s,  (s / l - 1)^2 for l < s,
//     g'(l) = 2 (l / s - 1) / s                            for l >= s,  -2 (s / l - 1) s / l^2 for l < s,
// Both branches have value 0 and second derivative 2 / s^2 at l = s, so f is smooth enough for conjugate gradient. As
// l^2 = e^T R^T R e, dl/dR = (R e) e^T / l, and
//     grad f = sum W g'(l) / l (R e) e^T.
// The search finds Q in R = Q R_0, starting at Q = 1, with edges R_0 e. The result then does not depend on how the mesh
// scales u and v.
#include "host/fields/inference/mapping/isometric_map.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

namespace multum {
namespace {

double dot(const glm::dmat2& a, const glm::dmat2& b) { return glm::dot(a[0], b[0]) + glm::dot(a[1], b[1]); }

glm::dmat2 diagonal_of(const glm::dmat2& m) { return {m[0][0], 0.0, 0.0, m[1][1]}; }

struct Point {
  glm::dmat2 map;
  double cost;
  glm::dmat2 gradient;
};

class Objective {
 public:
  Objective(const std::vector<IsometricEdge>& edges, bool is_diagonal) : edges_(edges), is_diagonal_(is_diagonal) {}
  Point at(const glm::dmat2& map) const {
    Point point{map, 0.0, glm::dmat2(0.0)};
    point.cost = isometric_cost(edges_, map, &point.gradient);
    if (is_diagonal_) point.gradient = diagonal_of(point.gradient);
    return point;
  }

 private:
  const std::vector<IsometricEdge>& edges_;
  bool is_diagonal_;
};

// Returns a point on the ray where the slope has fallen to a tenth of the slope at `start`. Doubles the step until it
// passes the minimum, which always exists because f is infinite where an edge vanishes. Then applies the secant method,
// but stays at least a tenth of the interval away from both of its ends.
Point line_minimum(const Objective& objective, const Point& start, const glm::dmat2& direction, double* step) {
  constexpr int kTries = 40;
  const double slope_start = dot(start.gradient, direction);
  double low = 0.0, slope_low = slope_start, high = 0.0, slope_high = 0.0, t = *step;
  bool is_bracketed = false;
  Point best = start;
  for (int i = 0; i < kTries; ++i) {
    const Point point = objective.at(start.map + t * direction);
    const bool is_finite = std::isfinite(point.cost) && std::isfinite(dot(point.gradient, point.gradient));
    const double slope = is_finite ? dot(point.gradient, direction) : std::numeric_limits<double>::infinity();
    if (is_finite && point.cost < best.cost) {
      best = point;
      *step = t;
    }
    if (is_finite && point.cost < start.cost && std::abs(slope) <= 0.1 * std::abs(slope_start)) return point;
    if (!is_finite || slope > 0.0 || point.cost > start.cost) {
      high = t;
      slope_high = slope;
      is_bracketed = true;
    } else {
      low = t;
      slope_low = slope;
    }
    if (!is_bracketed) {
      t *= 2.0;
      continue;
    }
    const double secant = low + (high - low) * slope_low / (slope_low - slope_high);
    const double edge = 0.1 * (high - low);
    t = std::isfinite(slope_high) && slope_high > 0.0 && secant > low + edge && secant < high - edge
            ? secant
            : 0.5 * (low + high);
  }
  return best;
}

}  // namespace

double isometric_cost(const std::vector<IsometricEdge>& edges, const glm::dmat2& map, glm::dmat2* gradient) {
  double cost = 0.0;
  glm::dmat2 sum(0.0);
  for (const IsometricEdge& edge : edges) {
    const glm::dvec2 mapped = map * edge.uv;
    const double l = glm::length(mapped), s = edge.length;
    if (!(l > 0.0)) return std::numeric_limits<double>::infinity();
    const double excess = l >= s ? l / s - 1.0 : s / l - 1.0;
    const double slope = l >= s ? 2.0 * excess / s : -2.0 * excess * s / (l * l);
    cost += edge.weight * excess * excess;
    const glm::dvec2 along = (edge.weight * slope / l) * mapped;
    sum[0] += along * edge.uv.x;
    sum[1] += along * edge.uv.y;
  }
  if (gradient != nullptr) *gradient = sum;
  return cost;
}

glm::dmat2 fit_isometric_map(const std::vector<IsometricEdge>& edges, const glm::dmat2& start,
                             const IsometricSettings& settings) {
  std::vector<IsometricEdge> scaled = edges;
  double weight_sum = 0.0;
  for (const IsometricEdge& edge : edges) weight_sum += edge.weight;
  if (!(weight_sum > 0.0)) return start;
  for (IsometricEdge& edge : scaled) {
    edge.uv = start * edge.uv;
    edge.weight /= weight_sum;
  }
  const Objective objective(scaled, settings.is_diagonal);
  Point here = objective.at(glm::dmat2(1.0));
  glm::dmat2 direction = -here.gradient;
  double step = 0.1;  // step of Q, whose elements are about 1
  for (int i = 0; i < settings.iterations_max && dot(here.gradient, here.gradient) > 1e-24; ++i) {
    if (dot(direction, here.gradient) >= 0.0)
      direction = -here.gradient;  // restarts if the direction does not lead
                                   // downhill
    const Point next = line_minimum(objective, here, direction, &step);
    const double decrease = here.cost - next.cost;
    // The factor of Polak and Ribiere, which is at least 0.
    const double beta = std::max(0.0, (dot(next.gradient, next.gradient) - dot(next.gradient, here.gradient)) /
                                          dot(here.gradient, here.gradient));
    direction = beta * direction - next.gradient;
    here = next;
    if (decrease <= settings.change_min * here.cost) break;
  }
  return here.map * start;
}

}  // namespace multum
