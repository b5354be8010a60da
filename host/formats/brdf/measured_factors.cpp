// SPDX-License-Identifier: Apache-2.0
// Alternating least squares: fits f for fixed g, then g for fixed f, each as a weighted quotient. The fit minimizes the
// sum over cells and channels of (rho - k_d / pi - f g)^2 / (rho + 0.01 of its mean), weighted by the products of solid
// angles and cosines for both angles. Therefore neither the peak nor the other cells are neglected. f may not grow with
// theta_h; neighbours that grow are replaced by their weighted mean. This has three reasons: facet distributions do not
// grow with theta_h, a sum of vMFs around h cannot grow, and pooling smooths a thousand scattered samples. All channels
// share one g, because three separate g with few samples each caused coloured fringes. k_d / pi is the mean of rho
// outside the highlight (theta_h from 45 to 75 degrees, theta_d below 45), and at most the mean of all cells.
#include "host/formats/brdf/measured_factors.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr int kRows = kFacetTableSize, kColumns = kDifferenceTableSize;
constexpr int kRoundCount = 30;

double theta_of_row(int row) {
  const double x = static_cast<double>(row) / (kRows - 1);
  return kHalfPi * x * x;
}
double theta_of_column(int column) { return kHalfPi * column / (kColumns - 1); }

std::size_t index(int row, int column) { return static_cast<std::size_t>(row * kColumns + column); }

// Fills the entries that have no measurements. Interpolates linearly between neighbours, and repeats the last measured
// entry after the end of the measurements.
void fill(std::vector<double>& values, const std::vector<bool>& known) {
  int before = -1;
  const int count = static_cast<int>(values.size());
  for (int i = 0; i <= count; ++i) {
    if (i < count && !known[static_cast<std::size_t>(i)]) continue;
    for (int k = before + 1; k < i; ++k) {
      const double t = static_cast<double>(k - before) / (i - before);
      const double low = before >= 0 ? values[static_cast<std::size_t>(before)] : values[static_cast<std::size_t>(i)];
      const double high = i < count ? values[static_cast<std::size_t>(i)] : low;
      values[static_cast<std::size_t>(k)] = before < 0 ? high : (1.0 - t) * low + t * high;
    }
    before = i;
  }
}

struct Cell {
  std::size_t row, column;
  glm::dvec3 rho;
  double area;        // product of solid angles and cosines
  glm::dvec3 weight;  // about area / rho
};

// Replaces values by the closest non-increasing sequence, by pooling neighbours (Barlow et al. 1972).
void hold_from_growing(std::vector<double>& values, const std::vector<double>& weights) {
  struct Pool {
    double value, weight;
    std::size_t count;
  };
  std::vector<Pool> pools;
  for (std::size_t i = 0; i < values.size(); ++i) {
    pools.push_back({values[i], std::max(weights[i], 1e-12), 1});
    while (pools.size() > 1 && pools[pools.size() - 2].value < pools.back().value) {
      const Pool last = pools.back();
      pools.pop_back();
      Pool& pool = pools.back();
      pool.value = (pool.value * pool.weight + last.value * last.weight) / (pool.weight + last.weight);
      pool.weight += last.weight;
      pool.count += last.count;
    }
  }
  std::size_t i = 0;
  for (const Pool& pool : pools)
    for (std::size_t k = 0; k < pool.count; ++k) values[i++] = pool.value;
}

// Returns the quotients of the sums, which are at least 0. Entries without a quotient are interpolated from their
// neighbours.
std::vector<double> quotients(const std::vector<double>& above, const std::vector<double>& below) {
  std::vector<double> values(above.size(), 0.0);
  std::vector<bool> known(above.size());
  for (std::size_t i = 0; i < above.size(); ++i) {
    known[i] = below[i] > 0.0;
    if (known[i]) values[i] = std::max(above[i] / below[i], 0.0);
  }
  if (std::find(known.begin(), known.end(), true) != known.end()) fill(values, known);
  return values;
}

void improve_facets(const std::vector<Cell>& cells, MeasuredBrdf& brdf) {
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<double> above(kRows, 0.0), below(kRows, 0.0);
    for (const Cell& cell : cells) {
      const double g = brdf.differences[cell.column];
      above[cell.row] += cell.weight[channel] * g * (cell.rho[channel] - brdf.diffuse[channel] / std::numbers::pi);
      below[cell.row] += cell.weight[channel] * g * g;
    }
    std::vector<double> f = quotients(above, below);
    hold_from_growing(f, below);
    for (std::size_t i = 0; i < f.size(); ++i) brdf.facets[i][channel] = f[i];
  }
}

void improve_differences(const std::vector<Cell>& cells, MeasuredBrdf& brdf) {
  std::vector<double> above(kColumns, 0.0), below(kColumns, 0.0);
  for (const Cell& cell : cells) {
    const glm::dvec3 f = brdf.facets[cell.row];
    above[cell.column] += glm::dot(cell.weight * f, cell.rho - brdf.diffuse / std::numbers::pi);
    below[cell.column] += glm::dot(cell.weight * f, f);
  }
  brdf.differences = quotients(above, below);
  // Scales g so that its mean is 1 over the difference angles with many measurements.
  double level = 0.0;
  for (int i = 0; i < 2 * kColumns / 3; ++i)
    level += brdf.differences[static_cast<std::size_t>(i)] / (2 * kColumns / 3);
  if (level <= 0.0) return;
  for (double& g : brdf.differences) g /= level;
  for (glm::dvec3& f : brdf.facets) f *= level;
}

glm::dvec3 diffuse_of(const std::vector<Cell>& cells) {
  glm::dvec3 all(0.0), matt(0.0);
  double area = 0.0, matt_area = 0.0;
  for (const Cell& cell : cells) {
    all += cell.area * cell.rho;
    area += cell.area;
    const double h = theta_of_row(static_cast<int>(cell.row)), d = theta_of_column(static_cast<int>(cell.column));
    if (h < 0.5 * kHalfPi || h > 0.83 * kHalfPi || d > 0.5 * kHalfPi) continue;
    matt += cell.area * cell.rho;
    matt_area += cell.area;
  }
  return matt_area > 0.0 ? std::numbers::pi * glm::min(matt / matt_area, all / area) : glm::dvec3(0.0);
}

}  // namespace

void half_angles(const glm::dvec3& l, const glm::dvec3& v, double* theta_h, double* theta_d) {
  const glm::dvec3 h = glm::normalize(l + v);
  *theta_h = std::acos(std::clamp(h.z, -1.0, 1.0));
  *theta_d = std::acos(std::clamp(glm::dot(l, h), -1.0, 1.0));
}

BrdfCells::BrdfCells()
    : sums_(static_cast<std::size_t>(kRows * kColumns), glm::dvec3(0.0)), counts_(sums_.size(), 0.0) {}

void BrdfCells::add(double theta_h, double theta_d, const glm::dvec3& rho) {
  if (!(theta_h >= 0.0 && theta_h <= kHalfPi && theta_d >= 0.0 && theta_d <= kHalfPi)) return;
  const int row = static_cast<int>(std::lround(std::sqrt(theta_h / kHalfPi) * (kRows - 1)));
  const int column = static_cast<int>(std::lround(theta_d / kHalfPi * (kColumns - 1)));
  sums_[index(row, column)] += rho;
  counts_[index(row, column)] += 1.0;
}

MeasuredBrdf BrdfCells::factor(const std::string& name) const {
  std::vector<Cell> cells;
  glm::dvec3 mean(0.0);
  double area = 0.0;
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      const double count = counts_[index(row, column)];
      if (count == 0.0) continue;
      const double h = theta_of_row(row), d = theta_of_column(column);
      // The width d theta_h of a row grows with the square root of theta_h. The lower limits avoid area 0 at theta_h =
      // 0 and at the horizon.
      const double cell_area =
          std::max(std::sin(h) * std::cos(h) * std::sqrt(h), 1e-4) * std::max(std::sin(d) * std::cos(d), 1e-2);
      const glm::dvec3 rho = sums_[index(row, column)] / count;
      cells.push_back({static_cast<std::size_t>(row), static_cast<std::size_t>(column), rho, cell_area, {}});
      mean += cell_area * rho;
      area += cell_area;
    }
  if (cells.empty()) throw Error(ErrorCode::kInput, name + ": contains no measurement above the horizon");
  mean /= area;
  if (!(mean.x + mean.y + mean.z > 0.0)) throw Error(ErrorCode::kInput, name + ": reflects nothing");
  for (Cell& cell : cells) cell.weight = cell.area / (cell.rho + 0.01 * mean + 1e-12);
  MeasuredBrdf brdf{name, diffuse_of(cells), std::vector<glm::dvec3>(kRows), std::vector<double>(kColumns, 1.0), 0.0};
  for (int round = 0; round < kRoundCount; ++round) {
    improve_facets(cells, brdf);
    improve_differences(cells, brdf);
  }
  double error = 0.0;
  for (const Cell& cell : cells) {
    const glm::dvec3 model = brdf.diffuse / std::numbers::pi + brdf.facets[cell.row] * brdf.differences[cell.column];
    const glm::dvec3 off = glm::abs(model - cell.rho);
    error += cell.area * (off.x + off.y + off.z);
  }
  brdf.relative_error = error / (area * (mean.x + mean.y + mean.z));
  return brdf;
}

}  // namespace multum
