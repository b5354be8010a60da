// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/accuracy_baselines.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/pyramid/mip_coverage.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {
namespace {

using Plane = std::vector<double>;

constexpr double kHorizonZ = 0.05;  // smallest z for slopes, because slopes are infinite at the horizon

// The planes that can be averaged linearly, which are the normal, its slopes and their products.
struct LinearPlanes {
  Plane nx, ny, nz, sx, sy, sxx, sxy, syy;
};

LinearPlanes finest_planes(const NormalMap& map) {
  LinearPlanes p;
  for (std::size_t i = 0; i < map.x.size(); ++i) {
    const double x = static_cast<double>(map.x[i]), y = static_cast<double>(map.y[i]),
                 z = static_cast<double>(map.z[i]);
    const double sx = x / std::max(z, kHorizonZ), sy = y / std::max(z, kHorizonZ);
    p.nx.push_back(x);
    p.ny.push_back(y);
    p.nz.push_back(z);
    p.sx.push_back(sx);
    p.sy.push_back(sy);
    p.sxx.push_back(sx * sx);
    p.sxy.push_back(sx * sy);
    p.syy.push_back(sy * sy);
  }
  return p;
}

LinearPlanes level_planes(const LinearPlanes& finest, PlaneSize from, PlaneSize to, int threads) {
  const auto average = [&](const Plane& plane) { return average_over_texels(plane, from, to, threads); };
  return {average(finest.nx), average(finest.ny),  average(finest.nz),  average(finest.sx),
          average(finest.sy), average(finest.sxx), average(finest.sxy), average(finest.syy)};
}

double stored(double value) { return std::nearbyint(value * 32767.0) / 32767.0; }

double blinn_phong(double t, double s) { return t > 0.0 ? (s + 1.0) / (2.0 * M_PI) * std::pow(t, s) : 0.0; }

double lean(const LinearPlanes& p, std::size_t i, const glm::dvec3& h, double s, bool jacobian) {
  if (h.z <= 0.0) return 0.0;
  const double xx = std::max(p.sxx[i] - p.sx[i] * p.sx[i], 0.0) + 1.0 / s;
  const double yy = std::max(p.syy[i] - p.sy[i] * p.sy[i], 0.0) + 1.0 / s;
  const double xy = p.sxy[i] - p.sx[i] * p.sy[i];
  const double determinant = std::max(xx * yy - xy * xy, 1e-12);
  const double dx = h.x / h.z - p.sx[i], dy = h.y / h.z - p.sy[i];
  const double exponent = -0.5 * (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / determinant;
  const double density = std::exp(exponent) / (2.0 * M_PI * std::sqrt(determinant));
  return jacobian ? density / (h.z * h.z * h.z) : density;
}

double model(Baseline baseline, const LinearPlanes& p, std::size_t i, const glm::dvec3& h, double s) {
  if (baseline == Baseline::kLean || baseline == Baseline::kLeanJacobian)
    return lean(p, i, h, s, baseline == Baseline::kLeanJacobian);
  const glm::dvec3 n(stored(p.nx[i]), stored(p.ny[i]), stored(p.nz[i]));
  const double length = std::min(glm::length(n), 1.0);
  const double t = glm::dot(n, h) / std::max(glm::length(n), 1e-9);
  if (baseline == Baseline::kMip) return blinn_phong(t, s);
  return blinn_phong(t, s * length / (length + s * (1.0 - length)));
}

constexpr Baseline kBaselines[] = {Baseline::kMip, Baseline::kToksvig, Baseline::kLean, Baseline::kLeanJacobian};

}  // namespace

const char* baseline_name(Baseline baseline) {
  switch (baseline) {
    case Baseline::kMip: return "mip";
    case Baseline::kToksvig: return "Toksvig";
    case Baseline::kLean: return "LEAN";
    case Baseline::kLeanJacobian: return "LEAN with Jacobian";
  }
  return "?";
}

std::vector<BaselineRow> measure_baselines(const NormalMap& map, const std::vector<double>& exponents, int threads) {
  const LinearPlanes finest = finest_planes(map);
  const PlaneSize full = {map.width, map.height};
  std::vector<BaselineRow> rows;
  for (int level = 0; level < mip_level_count(map.width, map.height); ++level) {
    const PlaneSize size = {mip_level_size(map.width, level), mip_level_size(map.height, level)};
    const LinearPlanes planes = level_planes(finest, full, size, threads);
    for (double s : exponents) {
      double reference_sum = 0.0, difference[4] = {0.0, 0.0, 0.0, 0.0};
      for (const glm::dvec3& h : accuracy_directions().half_vectors) {
        Plane reference(finest.nx.size());
        for (std::size_t i = 0; i < reference.size(); ++i)
          reference[i] = blinn_phong(h.x * finest.nx[i] + h.y * finest.ny[i] + h.z * finest.nz[i], s);
        reference = average_over_texels(reference, full, size, threads);
        for (std::size_t i = 0; i < reference.size(); ++i) {
          reference_sum += reference[i];
          for (std::size_t b = 0; b < 4; ++b)
            difference[b] += std::abs(model(kBaselines[b], planes, i, h, s) - reference[i]);
        }
      }
      for (std::size_t b = 0; b < 4; ++b)
        rows.push_back({level, kBaselines[b], s, reference_sum > 0.0 ? difference[b] / reference_sum : 0.0});
    }
  }
  return rows;
}

}  // namespace multum
