// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/movmf_start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <numeric>

#include "host/bakes/movmf/mip_schedule.h"
#include "host/bakes/movmf/normal_mixture.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/mean_cosine.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/split_mix.h"
#include "host/foundation/base/vector_clones.h"
#include "host/foundation/base/vector_exp.h"

namespace multum {
namespace {

using Lobe = MixtureLobe;
using Fit = MixtureFit;

// Divides `size` texels into `cells` cells, and returns a random position in cell number `cell`.
int position_in_cell(int cell, int cells, int size, std::uint64_t random) {
  const std::int64_t first = std::int64_t{cell} * size / cells, end = std::int64_t{cell + 1} * size / cells;
  return static_cast<int>(first + static_cast<std::int64_t>(random % static_cast<std::uint64_t>(end - first)));
}

// Returns one random normal per cell of a grid over a rectangle. The grid has at most about `sample_max` cells.
Normals sample_normals(const PlaneStore& map, const TexelRectangle& where, double sample_max) {
  const int width = where.x1 - where.x0, height = where.y1 - where.y0;
  const double stride = std::max(1.0, std::sqrt(static_cast<double>(width) * height / sample_max));
  const int columns = std::max(1, static_cast<int>(width / stride));
  const int rows = std::max(1, static_cast<int>(height / stride));
  Normals normals;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const std::uint64_t random =
          split_mix(static_cast<std::uint64_t>(row) * 65536u + static_cast<std::uint64_t>(column));
      const int x = where.x0 + position_in_cell(column, columns, width, random & 0xffffffffu);
      const int y = where.y0 + position_in_cell(row, rows, height, random >> 32);
      const std::array<float, 3> n = map.texel(x, y);
      normals.emplace_back(static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2]));
    }
  return normals;
}

// Ranks candidates by the error of their highlights relative to the highlights of the normals, for a broad, a medium
// and a sharp BRDF. A ranking by likelihood would favour sharp lobes around a few normals, although such lobes have
// little effect in a picture.
class HighlightError {
 public:
  explicit HighlightError(const Normals& normals) : directions_(spread_half_vectors(kDirections)) {
    for (std::size_t s = 0; s < kSharpness.size(); ++s) {
      Values sum{};
      for (const glm::dvec3& n : normals) add_highlight(n, kSharpness[s], sum);
      for (std::size_t d = 0; d < kDirections; ++d) reference_[s][d] = sum[d] / static_cast<double>(normals.size());
    }
  }

  double operator()(const Fit& fit) const {
    double error = 0.0;
    for (std::size_t s = 0; s < kSharpness.size(); ++s) {
      Values model{};
      for (const Lobe& lobe : fit.lobes) {
        // Mean cosines multiply under convolution (docs/contributing/ALGORITHMS.md, "Shading a filtered lobe").
        const double mean_cosine = lobe.mean_length * (1.0 - 1.0 / kSharpness[s]);
        add_density(kappa_of_mean_cosine(mean_cosine, 1e6), lobe.mu, lobe.amplitude, model);
      }
      double difference = 0.0, total = 0.0;
      for (std::size_t d = 0; d < kDirections; ++d) {
        difference += std::abs(model[d] - reference_[s][d]);
        total += reference_[s][d];
      }
      error += difference / total;
    }
    return error;
  }

 private:
  static constexpr int kDirections = 256;
  static constexpr std::array<double, 3> kSharpness = {20.0, 100.0, 500.0};
  using Values = std::array<double, kDirections>;  // [direction]

  // Adds the highlight of a normal. A shortened normal has the width of its own lobe.
  void add_highlight(const glm::dvec3& n, double sharpness, Values& sum) const {
    const double length = glm::length(n);
    if (length > 1.0 - 1e-6) add_density(sharpness, n, 1.0, sum);
    else add_density(kappa_of_mean_cosine(length * (1.0 - 1.0 / sharpness), 1e6), n / length, 1.0, sum);
  }
  void add_density(double kappa, const glm::dvec3& mu, double amplitude, Values& sum) const {
    add_densities(kappa, amplitude * kappa / (1.0 - std::exp(-2.0 * kappa)), mu.x, mu.y, mu.z, directions_, sum.data());
  }

  // The half vectors as coordinates.
  struct Directions {
    explicit Directions(const std::vector<glm::dvec3>& all) {
      for (std::size_t d = 0; d < kDirections; ++d) x[d] = all[d].x, y[d] = all[d].y, z[d] = all[d].z;
    }
    alignas(64) double x[kDirections], y[kDirections], z[kDirections];
  };

  MULTUM_VECTOR_CLONES
  static void add_densities(double kappa, double peak, double mu_x, double mu_y, double mu_z,
                            const Directions& directions, double* __restrict sum) {
    for (std::size_t d = 0; d < kDirections; ++d) {
      const double t = mu_x * directions.x[d] + mu_y * directions.y[d] + mu_z * directions.z[d];
      const double exponent = kappa * (t - 1.0);
      sum[d] += peak * exp_of_negative(exponent < 0.0 ? exponent : 0.0);
    }
  }

  const Directions directions_;
  std::array<Values, kSharpness.size()> reference_;
};

void rate(std::vector<Fit>& fits, const HighlightError& error, int threads) {
  for_each_item(static_cast<int>(fits.size()), threads, [&](int i) {
    Fit& fit = fits[static_cast<std::size_t>(i)];
    fit.error = error(fit);
  });
}

bool likelier(const Fit& a, const Fit& b) { return a.log_likelihood > b.log_likelihood; }
bool less_error(const Fit& a, const Fit& b) { return a.error < b.error; }
// Compares neighbours in a list that is sorted by error or likelihood.
bool same_optimum(const Fit& a, const Fit& b) { return std::abs(a.error - b.error) < 2e-3; }

// Returns the fits with the highest likelihoods and those with the lowest errors.
std::vector<Fit> finalists(std::vector<Fit> fits, const HighlightError& error, int threads) {
  constexpr std::size_t kLikeliest = 8, kLeastError = 16;
  rate(fits, error, threads);
  std::vector<Fit> kept;
  const auto keep = [&](std::size_t count, bool (*better)(const Fit&, const Fit&)) {
    std::stable_sort(fits.begin(), fits.end(), better);
    fits.erase(std::unique(fits.begin(), fits.end(), same_optimum), fits.end());
    kept.insert(kept.end(), fits.begin(), fits.begin() + static_cast<std::ptrdiff_t>(std::min(count, fits.size())));
  };
  keep(kLikeliest, likelier);
  keep(kLeastError, less_error);
  return kept;
}

}  // namespace

std::vector<MultumVmfLobe> farthest_first_lobes(const PlaneStore& map, const TexelRectangle& where, int lobe_count) {
  const Normals normals = sample_normals(map, where, 16384.0);
  std::vector<MultumVmfLobe> lobes;
  for (std::size_t i : farthest_first_normals(normals, lobe_count)) {
    const glm::vec3 r(normals[i] * 0.95);  // A(20)
    lobes.push_back({r.x, r.y, r.z, 1.0f / static_cast<float>(lobe_count)});
  }
  return lobes;
}

std::vector<MultumVmfLobe> start_lobes(std::vector<MultumVmfLobe> lobes, Representation representation,
                                       bool is_shortened) {
  if (!lobe_family(representation).is_planar) return lobes;
  for (MultumVmfLobe& lobe : lobes) {
    const float length = glm::length(glm::vec3(lobe.mean_x, lobe.mean_y, lobe.mean_z));
    lobe.mean_z = std::clamp(1.0f - length, 1e-6f, 0.5f);
    if (!is_shortened) continue;
    lobe.mean_x /= std::max(length, 1e-6f);
    lobe.mean_y /= std::max(length, 1e-6f);
  }
  return lobes;
}

namespace {

// Runs EM from many starts on a sample of a map's normals and returns the best fits.
class StartTrials {
 public:
  StartTrials(const Normals& normals, const StartSearch& search, bool is_shortened)
      : normals_(normals), search_(search), is_shortened_(is_shortened), error_(normals) {}

  std::vector<Fit> best_fits() const {
    const bool grows = search_.grows_starts && search_.lobe_count >= kGrownLobesMin;
    return grows ? best_fits(search_.lobe_count, best_fits(search_.lobe_count - kLobesAdded, {}))
                 : best_fits(search_.lobe_count, {});
  }

 private:
  // Many short trials are made first, and the best of them are continued as longer trials. This takes 0.2 s on one core
  // for any map size. On the four-quarter map with 4 lobes, about one random trial in 30 finds the basin of the best
  // optimum. With more lobes, the ratio is lower.
  static constexpr int kTrials = 128, kShortIterations = 12, kLongIterations = 30;
  // With 5 lobes or more, some trials start from the best fits with two lobes fewer, which are found more reliably, and
  // add two lobes. The error then never increases with the number of lobes. With 4 lobes or fewer, random trials
  // suffice.
  static constexpr int kGrownTrials = 48, kGrownLobesMin = 5, kLobesAdded = 2;
  static constexpr std::size_t kGrownFrom = 6;

  // Returns fits from random trials and from trials that grow from `smaller`, the lowest error first.
  std::vector<Fit> best_fits(int lobe_count, const std::vector<Fit>& smaller) const {
    std::vector<Fit> fits(static_cast<std::size_t>(kTrials + (smaller.empty() ? 0 : kGrownTrials)));
    for_each_item(static_cast<int>(fits.size()), search_.threads, [&](int trial) {
      Fit& fit = fits[static_cast<std::size_t>(trial)];
      fit = trial < kTrials ? start_mixture(normals_, choose_normals(trial, lobe_count), is_shortened_)
                            : grown_start(smaller, trial, lobe_count);
      iterate(fit, kShortIterations);
    });
    fits = finalists(std::move(fits), error_, search_.threads);
    for_each_item(static_cast<int>(fits.size()), search_.threads,
                  [&](int i) { iterate(fits[static_cast<std::size_t>(i)], kLongIterations); });
    rate(fits, error_, search_.threads);
    std::stable_sort(fits.begin(), fits.end(), less_error);
    fits.erase(std::unique(fits.begin(), fits.end(), same_optimum), fits.end());
    return fits;
  }

  std::size_t random_normal(int trial, int lobe) const {
    const auto draw = static_cast<std::uint64_t>(trial) * kLobeCountMax + static_cast<std::uint64_t>(lobe);
    return split_mix(search_.seed * 0x100000001b3u + draw) % normals_.size();
  }
  std::vector<std::size_t> choose_normals(int trial, int lobe_count) const {
    if (trial == 0) return farthest_first_normals(normals_, lobe_count);
    std::vector<std::size_t> numbers;
    for (int j = 0; j < lobe_count; ++j) numbers.push_back(random_normal(trial, j));
    return numbers;
  }
  Fit grown_start(const std::vector<Fit>& smaller, int trial, int lobe_count) const {
    Fit fit = smaller[static_cast<std::size_t>(trial) % std::min(smaller.size(), kGrownFrom)];
    std::vector<std::size_t> added;
    for (int j = static_cast<int>(fit.lobes.size()); j < lobe_count; ++j) added.push_back(random_normal(trial, j));
    for (Lobe& lobe : fit.lobes) lobe.amplitude *= 1.0 - static_cast<double>(added.size()) / lobe_count;
    for (Lobe lobe : start_mixture(normals_, added, is_shortened_).lobes) {
      lobe.amplitude = 1.0 / lobe_count;
      fit.lobes.push_back(lobe);
    }
    return fit;
  }
  void iterate(Fit& fit, int iterations) const {
    const double copies = is_shortened_ ? static_cast<double>(kCopiesShortened) : 1.0;
    iterate_mixture(fit, normals_, iterations, static_cast<double>(search_.kappa_max), copies);
  }

  const Normals& normals_;
  const StartSearch search_;
  const bool is_shortened_;
  const HighlightError error_;
};

}  // namespace

std::vector<std::vector<MultumVmfLobe>> start_candidates(const PlaneStore& map, const StartSearch& search) {
  const Normals normals = sample_normals(map, {0, 0, map.width(), map.height()}, 1024.0);
  const StartTrials trials(normals, search, map.is_shortened());
  std::vector<std::vector<MultumVmfLobe>> candidates;
  for (const Fit& fit : trials.best_fits()) {
    std::vector<MultumVmfLobe>& lobes = candidates.emplace_back();
    for (const Lobe& lobe : fit.lobes) {
      const glm::vec3 r(lobe.mu * std::min(lobe.mean_length, 1.0));
      lobes.push_back({r.x, r.y, r.z, static_cast<float>(lobe.amplitude)});
    }
  }
  return candidates;
}

NormalMap sample_proxy_map(const PlaneStore& map, int side_max, std::uint64_t seed) {
  NormalMap proxy;
  proxy.width = std::min(map.width(), side_max);
  proxy.height = std::min(map.height(), side_max);
  proxy.is_shortened = map.is_shortened();
  for (int y = 0; y < proxy.height; ++y)
    for (int x = 0; x < proxy.width; ++x) {
      const std::uint64_t random = split_mix(seed * 0x100000001b3u + static_cast<std::uint64_t>(y * proxy.width + x));
      const int source_x = position_in_cell(x, proxy.width, map.width(), random & 0xffffffffu);
      const int source_y = position_in_cell(y, proxy.height, map.height(), random >> 32);
      const std::array<float, 3> n = map.texel(source_x, source_y);
      proxy.x.push_back(n[0]);
      proxy.y.push_back(n[1]);
      proxy.z.push_back(n[2]);
    }
  return proxy;
}

std::vector<glm::dvec3> spread_half_vectors(int count) {
  // The squared heights and the azimuths of light and view follow a Kronecker sequence in four dimensions. The steps of
  // the sequence are the powers of the inverse root of x^5 = x + 1, which generalises the golden ratio (Roberts 2018).
  constexpr double kRoot = 1.16730397826141868;
  const auto direction = [](double height, double turn) {
    const double side = std::sqrt(1.0 - height * height), azimuth = 2.0 * std::numbers::pi * turn;
    return glm::dvec3(side * std::cos(azimuth), side * std::sin(azimuth), height);
  };
  std::vector<glm::dvec3> half_vectors;
  for (int i = 0; i < (count + 3) / 4; ++i) {
    std::array<double, 4> u{};
    double step = 1.0;
    for (double& value : u) value = std::fmod(0.5 + (i + 1) * (step /= kRoot), 1.0);
    glm::dvec3 h = glm::normalize(direction(std::sqrt(u[0]), u[1]) + direction(std::sqrt(u[2]), u[3]));
    for (int quarter_turn = 0; quarter_turn < 4; ++quarter_turn, h = {-h.y, h.x, h.z}) half_vectors.push_back(h);
  }
  return half_vectors;
}

}  // namespace multum
