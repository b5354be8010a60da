// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/normal_mixture.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <numeric>

#include "host/foundation/base/error.h"
#include "host/foundation/base/mean_cosine.h"
#include "host/foundation/base/vector_clones.h"
#include "host/foundation/base/vector_exp.h"

namespace multum {

MixtureFit start_mixture(const Normals& normals, const std::vector<std::size_t>& chosen, bool is_shortened) {
  MixtureFit fit;
  for (std::size_t i : chosen) {
    MixtureLobe lobe{normals[i], 0.95, 30.0, 1.0 / static_cast<double>(chosen.size())};
    if (is_shortened) {  // the lobe has the width of the normal's own lobe, because on a flat surface lobes differ only
                         // in width
      const double length = glm::length(normals[i]);
      lobe = {normals[i] / length, 0.95 * length, kappa_of_mean_cosine(0.95 * length, 30.0), lobe.amplitude};
    }
    fit.lobes.push_back(lobe);
  }
  return fit;
}

namespace {

constexpr std::size_t kLanes = 8;  // sums have one part per lane, so their order is the same for all vector widths
constexpr std::size_t kLobesMax = 8;
constexpr std::size_t kBlock = 64;  // normals that are handled together, a multiple of kLanes

// Normals as coordinates. The last block is filled with normals that are not present.
struct NormalBlocks {
  explicit NormalBlocks(const Normals& normals)
      : count((normals.size() + kBlock - 1) / kBlock * kBlock), x(count), y(count), z(count), is_present(count) {
    for (std::size_t i = 0; i < normals.size(); ++i) {
      x.data()[i] = normals[i].x;
      y.data()[i] = normals[i].y;
      z.data()[i] = normals[i].z;
      is_present.data()[i] = 1.0;
    }
  }
  std::size_t count;
  AlignedRow x, y, z;
  AlignedRow is_present;  // 1 or 0
};

// A lobe during an E-step. Its log density at n is log_peak + sharpness (mu . n - 1).
struct LobeTerm {
  double x, y, z, sharpness, log_peak;
};

// Sums over all normals. [4 j + 0] is the weight of lobe j, and [4 j + 1] to [4 j + 3] are the sums of its normals.
struct MixtureSums {
  double lobes[4 * kLobesMax];
  double log_likelihood;
};

// GCC's vectors, because GCC compiles loops over arrays of kLanes numbers to shuffles.
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double)), may_alias));

MULTUM_VECTOR_CLONES
void sum_responsibilities(const LobeTerm* lobes, std::size_t lobe_count, const double* x, const double* y,
                          const double* z, const double* is_present, std::size_t count, MixtureSums* sums) {
  Lanes parts[4 * kLobesMax] = {};
  double log_likelihood = 0.0;
  for (std::size_t first = 0; first < count; first += kBlock) {
    alignas(Lanes) double e[kLobesMax][kBlock], largest[kBlock], total[kBlock];
    for (std::size_t j = 0; j < lobe_count; ++j) {
      const LobeTerm lobe = lobes[j];
      for (std::size_t i = 0; i < kBlock; ++i) {
        const double t = lobe.x * x[first + i] + lobe.y * y[first + i] + lobe.z * z[first + i];
        e[j][i] = lobe.log_peak + lobe.sharpness * (t - 1.0);
      }
    }
    for (std::size_t i = 0; i < kBlock; ++i) largest[i] = -HUGE_VAL;
    for (std::size_t j = 0; j < lobe_count; ++j)
      for (std::size_t i = 0; i < kBlock; ++i) largest[i] = e[j][i] > largest[i] ? e[j][i] : largest[i];
    for (std::size_t i = 0; i < kBlock; ++i) total[i] = 0.0;
    for (std::size_t j = 0; j < lobe_count; ++j)
      for (std::size_t i = 0; i < kBlock; ++i) total[i] += e[j][i] = exp_of_negative(e[j][i] - largest[i]);
    for (std::size_t j = 0; j < lobe_count; ++j) {
      Lanes weight = parts[4 * j], sum_x = parts[4 * j + 1], sum_y = parts[4 * j + 2], sum_z = parts[4 * j + 3];
      for (std::size_t i = 0; i < kBlock; i += kLanes) {
        const auto at = [i](const double* values) { return reinterpret_cast<const Lanes*>(values + i); };
        const Lanes part = *at(e[j]) / *at(total) * *at(is_present + first);
        weight += part;
        sum_x += part * *at(x + first);
        sum_y += part * *at(y + first);
        sum_z += part * *at(z + first);
      }
      parts[4 * j] = weight;
      parts[4 * j + 1] = sum_x;
      parts[4 * j + 2] = sum_y;
      parts[4 * j + 3] = sum_z;
    }
    // The logarithm of a product replaces a sum of logarithms. Totals are in the range 1 to 8, so 64 of them do not
    // overflow.
    double product = 1.0, largest_sum = 0.0;
    for (std::size_t i = 0; i < kBlock; ++i) {
      product *= is_present[first + i] > 0.0 ? total[i] : 1.0;
      largest_sum += largest[i] * is_present[first + i];
    }
    log_likelihood += largest_sum + std::log(product);
  }
  for (std::size_t k = 0; k < 4 * lobe_count; ++k) {
    double sum = 0.0;
    for (std::size_t lane = 0; lane < kLanes; ++lane) sum += parts[k][lane];
    sums->lobes[k] = sum;
  }
  sums->log_likelihood = log_likelihood;
}

}  // namespace

void iterate_mixture(MixtureFit& fit, const Normals& normals, int iterations, double kappa_max, double copies) {
  const std::size_t count = fit.lobes.size();
  MULTUM_CHECK(count >= 1 && count <= kLobesMax);
  NormalBlocks blocks(normals);
  for (int iteration = 0; iteration < iterations; ++iteration) {
    std::array<LobeTerm, kLobesMax> terms;
    for (std::size_t j = 0; j < count; ++j) {
      const MixtureLobe& lobe = fit.lobes[j];
      const double peak = lobe.kappa / (1.0 - std::exp(-2.0 * lobe.kappa));
      terms[j] = {lobe.mu.x, lobe.mu.y, lobe.mu.z, copies * lobe.kappa,
                  std::log(std::max(lobe.amplitude, 1e-6) * peak) + (copies - 1.0) * std::log(peak)};
    }
    MixtureSums sums;
    sum_responsibilities(terms.data(), count, blocks.x.data(), blocks.y.data(), blocks.z.data(),
                         blocks.is_present.data(), blocks.count, &sums);
    fit.log_likelihood = sums.log_likelihood / static_cast<double>(normals.size());
    for (std::size_t j = 0; j < count; ++j) {
      MixtureLobe& lobe = fit.lobes[j];
      const double weight = sums.lobes[4 * j];
      const glm::dvec3 sum(sums.lobes[4 * j + 1], sums.lobes[4 * j + 2], sums.lobes[4 * j + 3]);
      lobe.amplitude = weight / static_cast<double>(normals.size());
      const double length = glm::length(sum);
      if (weight < 1e-9 || length < 1e-9) continue;
      lobe.mu = sum / length;
      lobe.mean_length = std::min(length / weight, 1.0);
      lobe.kappa = kappa_of_mean_cosine(lobe.mean_length, kappa_max);
    }
  }
}

std::vector<std::size_t> farthest_first_normals(const Normals& normals, int count) {
  const glm::dvec3 mean = std::accumulate(normals.begin(), normals.end(), glm::dvec3(0.0));
  // closest[i] is the cosine between normal i and the nearest chosen normal. Before the first choice, the mean is used.
  std::vector<double> closest(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) closest[i] = glm::dot(normals[i], mean);
  std::vector<std::size_t> chosen;
  for (int j = 0; j < count; ++j) {
    chosen.push_back(static_cast<std::size_t>(std::min_element(closest.begin(), closest.end()) - closest.begin()));
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const double cosine = glm::dot(normals[i], normals[chosen.back()]);
      closest[i] = j == 0 ? cosine : std::max(closest[i], cosine);
    }
  }
  return chosen;
}

}  // namespace multum
