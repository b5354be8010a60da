// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/brdf_rows.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <glm/geometric.hpp>

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/mean_cosine.h"

namespace multum {
namespace {

constexpr int kColumnsOfBlock = 128;  // with this number, about twelve powers of a block fit into the first-level cache
constexpr double kIntegerMax = 1e6;

MULTUM_VECTOR_CLONES
void clamped_cosines(const float* __restrict x, const float* __restrict y, const float* __restrict z, double omega_x,
                     double omega_y, double omega_z, int count, double* __restrict cosines) {
  for (int i = 0; i < count; ++i) {
    const double t =
        omega_x * static_cast<double>(x[i]) + omega_y * static_cast<double>(y[i]) + omega_z * static_cast<double>(z[i]);
    cosines[i] = t > 0.0 ? t : 0.0;
  }
}

// Processes whole blocks only, so that the inner loops have no remainder.
MULTUM_VECTOR_CLONES
void multiply_powers(const PowerProduct* products, std::size_t product_count, double* const* powers) {
  for (std::size_t p = 0; p < product_count; ++p) {
    const double* first = powers[products[p].first];
    const double* second = powers[products[p].second];
    double* __restrict product = powers[p + 1];
    for (int i = 0; i < kColumnsOfBlock; ++i) product[i] = first[i] * second[i];
  }
}

// Adds products until t^n is available, and returns the number of this power. If n is the sum of two available
// exponents, one product is enough. Otherwise t^n is the square of t^(n/2) or, for odd n, t^(n-1) times t.
int reach(int n, std::map<int, int>& at_hand, std::vector<PowerProduct>& products) {
  if (const auto found = at_hand.find(n); found != at_hand.end()) return found->second;
  PowerProduct product{-1, -1};
  for (const auto& [other, power] : at_hand)
    if (const auto rest = at_hand.find(n - other); rest != at_hand.end()) product = {power, rest->second};
  if (product.first < 0) {
    const int part = n % 2 == 0 ? n / 2 : n - 1;
    product.first = reach(part, at_hand, products);
    product.second = n % 2 == 0 ? product.first : 0;
  }
  products.push_back(product);
  return at_hand[n] = static_cast<int>(products.size());
}

}  // namespace

PowerPlan plan_powers(const std::vector<double>& exponents) {
  PowerPlan plan;
  plan.whole.assign(exponents.size(), -1);
  std::vector<std::size_t> order(exponents.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return exponents[a] < exponents[b]; });
  std::map<int, int> at_hand{{1, 0}};
  for (const std::size_t e : order) {
    const bool is_whole =
        exponents[e] >= 1.0 && exponents[e] <= kIntegerMax && exponents[e] == std::floor(exponents[e]);
    if (is_whole) plan.whole[e] = reach(static_cast<int>(exponents[e]), at_hand, plan.products);
  }
  return plan;
}

void evaluate_shortened(const glm::dvec3& omega, bool is_lambert, const std::array<const float*, 3>& normals, int count,
                        double* values) {
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 n(static_cast<double>(normals[0][i]), static_cast<double>(normals[1][i]),
                       static_cast<double>(normals[2][i]));
    const double length = glm::length(n), r = std::min(length, 1.0), t = glm::dot(n, omega) / length;
    if (is_lambert) {
      values[i] = std::max(t, 0.0);
    } else {
      constexpr double kExponent = static_cast<double>(kRoughnessExponent);
      const double kappa = kappa_of_mean_cosine(r * (kExponent + 1.0) / (kExponent + 2.0), kExponent);
      values[i] = kappa / (2.0 * std::numbers::pi * (1.0 - std::exp(-2.0 * kappa))) * std::exp(kappa * (t - 1.0));
    }
  }
}

BrdfRows::BrdfRows(const glm::dvec3& omega, const std::vector<double>& exponents)
    : omega_(omega),
      exponents_(exponents),
      plan_(plan_powers(exponents)),
      powers_((plan_.products.size() + 1) * std::size_t{kColumnsOfBlock}) {}

void BrdfRows::evaluate(const std::array<const float*, 3>& normals, int count, const std::vector<double*>& rows) {
  const auto own = [&](std::size_t power) { return powers_.data() + power * kColumnsOfBlock; };
  std::vector<double*> powers(plan_.products.size() + 1);
  for (std::size_t p = 0; p < powers.size(); ++p) powers[p] = own(p);
  for (int begin = 0; begin < count; begin += kColumnsOfBlock) {
    const int size = std::min(kColumnsOfBlock, count - begin);
    // Results of whole blocks are written directly to the output.
    for (std::size_t e = 0; e < exponents_.size() && size == kColumnsOfBlock; ++e)
      if (plan_.whole[e] > 0) powers[static_cast<std::size_t>(plan_.whole[e])] = rows[e] + begin;
    clamped_cosines(normals[0] + begin, normals[1] + begin, normals[2] + begin, omega_.x, omega_.y, omega_.z, size,
                    powers[0]);
    for (std::size_t p = 1; p < powers.size() && size < kColumnsOfBlock; ++p) powers[p] = own(p);
    multiply_powers(plan_.products.data(), plan_.products.size(), powers.data());
    for (std::size_t e = 0; e < exponents_.size(); ++e) {
      double* row = rows[e] + begin;
      const double* power = powers[plan_.whole[e] >= 0 ? static_cast<std::size_t>(plan_.whole[e]) : 0];
      if (plan_.whole[e] < 0)
        std::transform(power, power + size, row, [&](double t) { return std::pow(t, exponents_[e]); });
      else if (power != row) std::copy_n(power, size, row);
    }
  }
}

}  // namespace multum
