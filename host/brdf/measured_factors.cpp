// SPDX-License-Identifier: Apache-2.0
// Alternating least squares: f given g, then g given f, each the weighted quotient that minimises the sum over cells of
// (rho - k_d / pi - f g)^2 / (rho + 0.01 of its mean), weight = solid angles of both angles times their cosines:
// neither the peak nor the rest is left alone. k_d / pi is the mean of rho where no highlight is: theta_h of 45 to 75
// degrees, theta_d below 45, and at most the mean of everything.
#include "host/brdf/measured_factors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/base/error.h"

namespace multum {
namespace {

constexpr double kHalfPi = 0.5 * std::numbers::pi;
constexpr int kRows = kFacetTableSize, kColumns = kDifferenceTableSize;
constexpr int kRoundCount = 30;

double theta_of_row(int row) {
  const double x = static_cast<double>(row) / (kRows - 1);
  return kHalfPi * x * x;
}
double theta_of_column(int column) { return kHalfPi * column / (kColumns - 1); }

std::size_t index(int row, int column) { return static_cast<std::size_t>(row * kColumns + column); }

// Entries that nothing was measured for: linear between their neighbours, constant beyond the last.
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
  int row, column;
  double rho, weight;
};

struct Factors {
  double diffuse;  // k_d / pi
  std::vector<double> f, g;
  double error, total;  // relative L1's parts
};

// The weighted quotients of one factor, `own` and `other` being a cell's entries in it and in the other.
template <typename Own, typename Other>
void improve(const std::vector<Cell>& cells, double diffuse, const std::vector<double>& other_values, const Own& own,
             const Other& other, std::vector<double>& values) {
  std::vector<double> above(values.size(), 0.0), below(values.size(), 0.0);
  for (const Cell& cell : cells) {
    const double x = other_values[other(cell)];
    above[own(cell)] += cell.weight * x * (cell.rho - diffuse);
    below[own(cell)] += cell.weight * x * x;
  }
  std::vector<bool> known(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    known[i] = below[i] > 0.0;
    if (known[i]) values[i] = std::max(above[i] / below[i], 0.0);
  }
  if (std::find(known.begin(), known.end(), true) != known.end()) fill(values, known);
}

Factors factor_channel(std::vector<Cell> cells) {
  double mean = 0.0, area = 0.0, matt = 0.0, matt_area = 0.0;
  for (const Cell& cell : cells) {
    mean += cell.weight * cell.rho;
    area += cell.weight;
    const double h = theta_of_row(cell.row), d = theta_of_column(cell.column);
    if (h < 0.5 * kHalfPi || h > 0.83 * kHalfPi || d > 0.5 * kHalfPi) continue;
    matt += cell.weight * cell.rho;
    matt_area += cell.weight;
  }
  mean /= area;
  Factors factors{matt_area > 0.0 ? std::min(matt / matt_area, mean) : 0.0, std::vector<double>(kRows, 0.0),
                  std::vector<double>(kColumns, 1.0), 0.0, 0.0};
  const std::vector<Cell> plain = cells;
  for (Cell& cell : cells) cell.weight /= cell.rho + 0.01 * mean + 1e-12;
  const auto row = [](const Cell& c) { return static_cast<std::size_t>(c.row); };
  const auto column = [](const Cell& c) { return static_cast<std::size_t>(c.column); };
  for (int round = 0; round < kRoundCount; ++round) {
    improve(cells, factors.diffuse, factors.g, row, column, factors.f);
    improve(cells, factors.diffuse, factors.f, column, row, factors.g);
    // g is 1 on average over the difference angles that are measured well.
    double level = 0.0;
    for (int i = 0; i < 2 * kColumns / 3; ++i) level += factors.g[static_cast<std::size_t>(i)] / (2 * kColumns / 3);
    if (level <= 0.0) break;
    for (double& g : factors.g) g /= level;
    for (double& f : factors.f) f *= level;
  }
  for (const Cell& cell : plain) {
    const double model = factors.diffuse + factors.f[row(cell)] * factors.g[column(cell)];
    factors.error += cell.weight * std::abs(model - cell.rho);
    factors.total += cell.weight * cell.rho;
  }
  return factors;
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
  MeasuredBrdf brdf{name, glm::dvec3(0.0), std::vector<glm::dvec3>(kRows), std::vector<glm::dvec3>(kColumns), 0.0};
  double error = 0.0, total = 0.0;
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<Cell> cells;
    for (int row = 0; row < kRows; ++row)
      for (int column = 0; column < kColumns; ++column) {
        const double count = counts_[index(row, column)];
        if (count == 0.0) continue;
        const double h = theta_of_row(row), d = theta_of_column(column);
        // d theta_h of a row grows as its square root; half a cell at 0 and at the horizon would be 0.
        const double weight =
            std::max(std::sin(h) * std::cos(h) * std::sqrt(h), 1e-4) * std::max(std::sin(d) * std::cos(d), 1e-2);
        cells.push_back({row, column, sums_[index(row, column)][channel] / count, weight});
      }
    if (cells.empty()) throw Error(ErrorCode::kInput, name + ": holds no measurement above the horizon");
    const Factors factors = factor_channel(std::move(cells));
    brdf.diffuse[channel] = std::numbers::pi * factors.diffuse;
    for (std::size_t i = 0; i < kRows; ++i) brdf.facets[i][channel] = factors.f[i];
    for (std::size_t i = 0; i < kColumns; ++i) brdf.differences[i][channel] = factors.g[i];
    error += factors.error;
    total += factors.total;
  }
  if (!(total > 0.0)) throw Error(ErrorCode::kInput, name + ": reflects nothing");
  brdf.relative_error = error / total;
  return brdf;
}

}  // namespace multum
