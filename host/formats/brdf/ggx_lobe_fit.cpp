// SPDX-License-Identifier: Apache-2.0
#include "host/formats/brdf/ggx_lobe_fit.h"

#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/SpecialFunctions>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "host/formats/brdf/facet_distribution.h"
#include "host/formats/brdf/vmf_terms.h"
#include "host/foundation/base/gauss_legendre.h"

namespace multum {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kSide = kGgxLobeTableSide;
constexpr double kPull = 0.06;      // weight of the difference between a logarithm and the mean of its neighbours
constexpr int kSweepCount = 3;      // number of sweeps after the first sweep, in which a cell has only two neighbours
constexpr double kWidthMin = 0.01;  // smallest s; below it, shapes do not depend on s
constexpr double kSpreadMin = 1e-9, kSpreadMax = 1.0 - 1e-5;
constexpr double kLeastPart = 1e-6;  // weights stop growing where the exact value is below this share of its maximum

double versine(double angle) {  // 1 - cos
  const double half = std::sin(0.5 * angle);
  return 2.0 * half * half;
}

// Appends the geometric sequence begin, begin q, ... end.
void add_geometric(double begin, double end, int count, std::vector<double>& values) {
  for (int i = 0; i < count; ++i) values.push_back(begin * std::pow(end / begin, i / (count - 1.0)));
}

struct Cell {
  double alpha, spread;
  std::vector<double> e, exact, scale;  // `scale` is sqrt(solid angle / exact value)
};

using Vector = Eigen::VectorXd;

Vector logarithms(const GgxLobeShape& shape) {
  Vector values(4);
  values << std::log(shape.peak), std::log(shape.slope), std::log(shape.bend), std::log(shape.power);
  return values;
}

GgxLobeShape shape_of(const Vector& values) {
  return {std::exp(values[0]), std::exp(values[1]), std::exp(values[2]), std::exp(values[3])};
}

Cell cell_of(std::size_t row, std::size_t column) {
  static const QuadratureRule rule = gauss_legendre(6);
  const double s = std::max(std::numbers::sqrt3 * static_cast<double>(row) / (kSide - 1), kWidthMin);
  const double part = static_cast<double>(column) / (kSide - 1);
  // alpha and d end at 1, but a filter also reads texels beyond this end.
  const double alpha = std::min(part * s, 1.0);
  Cell cell{std::max(alpha, 1e-4 * s), std::clamp(0.5 * (s * s - alpha * alpha), kSpreadMin, kSpreadMax), {}, {}, {}};
  const double kappa = vmf_kappa(cell.spread);
  std::vector<double> edges = {0.0};
  const double width = std::min(std::sqrt(cell.alpha * cell.alpha + 2.0 / (kappa + 1.0)), 1.0);
  if (width < 0.7) add_geometric(0.1 * width, kPi, 12, edges);
  else
    for (int i = 1; i <= 12; ++i) edges.push_back(kPi * i / 12);
  std::vector<double> angles;
  double total = 0.0, most = 0.0;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i)
    for (std::size_t j = 0; j < rule.nodes.size(); ++j) {
      const double half = 0.5 * (edges[i + 1] - edges[i]);
      const double theta = edges[i] + half * (1.0 + rule.nodes[j]);
      cell.e.push_back(versine(theta));
      cell.exact.push_back(convolved_ggx_facets(cell.alpha, kappa, theta));
      angles.push_back(2.0 * kPi * std::sin(theta) * half * rule.weights[j]);
      total += cell.exact.back() * angles.back();
      most = std::max(most, cell.exact.back());
    }
  for (std::size_t i = 0; i < cell.e.size(); ++i)
    cell.scale.push_back(std::sqrt(angles[i] / std::max(cell.exact[i], kLeastPart * most) / total));
  return cell;
}

/// Residuals in the form that Eigen's solver requires.
struct CellResiduals {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  int inputs() const { return 4; }
  int values() const { return static_cast<int>(cell.e.size()) + 4; }
  int operator()(const Vector& logs, Vector& residuals) const {
    const GgxLobeShape shape = shape_of(logs);
    const auto count = static_cast<Eigen::Index>(cell.e.size());
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      residuals[i] = cell.scale[k] * (ggx_lobe_density(shape, cell.alpha, cell.spread, cell.e[k]) - cell.exact[k]);
    }
    for (Eigen::Index i = 0; i < 4; ++i) residuals[count + i] = kPull * (logs[i] - pulled_to[i]);
    return 0;
  }

  const Cell& cell;
  Vector pulled_to;
};

// Fits a cell from each set of starting values and returns the best result.
GgxLobeShape fit_cell(const Cell& cell, const Vector& pulled_to, const std::vector<Vector>& starts) {
  const CellResiduals residuals{cell, pulled_to};
  Vector best = pulled_to;
  double least = std::numeric_limits<double>::infinity();
  for (Vector logs : starts) {
    Eigen::NumericalDiff<CellResiduals> differences(residuals);
    Eigen::LevenbergMarquardt<Eigen::NumericalDiff<CellResiduals>> solver(differences);
    solver.minimize(logs);
    if (!(solver.fnorm < least)) continue;
    least = solver.fnorm;
    best = logs;
  }
  return shape_of(best);
}

}  // namespace

// Integrates over rings about h. The integral of the vMF around a ring is the Bessel function I_0.
double convolved_ggx_facets(double alpha, double kappa, double theta) {
  static const QuadratureRule rule = gauss_legendre(10);
  const double width = 1.0 / std::sqrt(kappa + 1.0);
  std::vector<double> edges = {0.0};
  add_geometric(0.05 * alpha, 0.5 * kPi, 10, edges);
  for (int i = -8; i <= 8; ++i)
    if (const double edge = theta + width * i; edge > 0.0 && edge < 0.5 * kPi) edges.push_back(edge);
  std::sort(edges.begin(), edges.end());
  const double scale = kappa / -std::expm1(-2.0 * kappa);
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i)
    for (std::size_t j = 0; j < rule.nodes.size(); ++j) {
      const double half = 0.5 * (edges[i + 1] - edges[i]);
      const double ring = edges[i] + half * (1.0 + rule.nodes[j]);
      const double exponent = kappa * versine(theta - ring);
      if (exponent > 60.0) continue;
      const double around = Eigen::numext::bessel_i0e(kappa * std::sin(theta) * std::sin(ring));
      sum += half * rule.weights[j] * ggx_density(alpha, versine(ring)) * std::sin(ring) * scale * around *
             std::exp(-exponent);
    }
  return sum;
}

std::vector<GgxLobeShape> fit_ggx_lobe_table() {
  std::vector<Cell> cells;
  for (std::size_t row = 0; row < kSide; ++row)
    for (std::size_t column = 0; column < kSide; ++column) cells.push_back(cell_of(row, column));
  std::vector<GgxLobeShape> shapes(cells.size());
  const auto neighbours_mean = [&](std::size_t row, std::size_t column) {
    Vector sum = Vector::Zero(4);
    double count = 0.0;
    const auto add = [&](bool is_there, std::size_t i) {
      if (!is_there) return;
      sum += logarithms(shapes[i]);
      count += 1.0;
    };
    const std::size_t i = row * kSide + column;
    add(row > 0, i - kSide);
    add(row + 1 < kSide, i + kSide);
    add(column > 0, i - 1);
    add(column + 1 < kSide, i + 1);
    return Vector(sum / count);
  };
  // Starts with single normals, whose shape is known, and continues with broader and broader lobes.
  for (int sweep = 0; sweep <= kSweepCount; ++sweep)
    for (std::size_t row = 0; row < kSide; ++row)
      for (std::size_t column = kSide; column-- > 0;) {
        const std::size_t i = row * kSide + column;
        const Cell& cell = cells[i];
        const double b = 4.0 * (1.0 - cell.alpha * cell.alpha);
        const GgxLobeShape single{1.0, std::max(b, 0.03), 0.25, 1.0};
        if (cell.spread <= kSpreadMin) {
          shapes[i] = single;
          continue;
        }
        const Vector before = logarithms(column + 1 < kSide ? shapes[i + 1] : single);
        const Vector pulled_to = sweep == 0 ? before : neighbours_mean(row, column);
        std::vector<Vector> starts = {pulled_to};
        if (sweep > 0) starts.push_back(logarithms(shapes[i]));
        else if (row > 0) starts.push_back(logarithms(shapes[i - kSide]));
        shapes[i] = fit_cell(cell, pulled_to, starts);
      }
  return shapes;
}

}  // namespace multum
