// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/averages/moment_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/formats/asset/averages/moment_file.h"
#include "host/formats/asset/verify_scan.h"

namespace multum {

struct MomentScan::Texels {
  std::size_t nonfinite = 0;
  WorstTexel variance, slope, length, weight;  // how much values exceed their tolerances
};

namespace {

// Tolerances for rounding (docs/reference/file_format.md). A variance or covariance may be wrong by this fraction of
// its moment, and a length may be wrong by this amount. Rounding to 16-bit floats lowers a square by up to a whole
// step, which is 2^-10 of its value. Averaging in float adds an error of about 2^-24.
double variance_tolerance(StorageEncoding encoding) { return encoding == StorageEncoding::kHalf ? 1.05e-3 : 2e-6; }
double length_tolerance(StorageEncoding encoding) { return encoding == StorageEncoding::kHalf ? 2e-3 : 1e-6; }

bool is_finite(const float* values, int count) {
  return std::all_of(values, values + count, [](float value) { return std::isfinite(value); });
}

// Returns how much a second moment is too small for its means, beyond the tolerance for rounding. A covariance must
// also obey the Cauchy-Schwarz inequality.
double missing_variance(const SlopeMoments& m, double tolerance) {
  constexpr double kLeastStep = 6e-8;  // spacing of 16-bit floats near zero
  const auto room = [&](double moment) { return tolerance * std::abs(moment) + kLeastStep; };
  const double s = static_cast<double>(m.s), t = static_cast<double>(m.t);
  const double room_s = room(std::max(static_cast<double>(m.ss), s * s));
  const double room_t = room(std::max(static_cast<double>(m.tt), t * t));
  const double ss = static_cast<double>(m.ss) - s * s, tt = static_cast<double>(m.tt) - t * t;
  const double st = static_cast<double>(m.st) - s * t;
  const double wide_s = std::max(ss, 0.0) + room_s, wide_t = std::max(tt, 0.0) + room_t;
  const double excess = std::abs(st) - std::sqrt(wide_s * wide_t) - room(static_cast<double>(m.st));
  return std::max({-ss - room_s, -tt - room_t, excess, 0.0});
}

void scan_texel(const BakedHeader& header, const MomentLevel& rows, std::size_t i, const TexelPlace& place,
                MomentScan::Texels& scan) {
  const SlopeMoments& m = rows.slopes[i];
  const glm::vec3& n = rows.normals[i];
  if (!is_finite(&m.height, 6) || !is_finite(&n.x, 3) || (!rows.colours.empty() && !is_finite(&rows.colours[i].x, 3))) {
    ++scan.nonfinite;
    return;
  }
  const double tolerance = length_tolerance(header.encoding);
  scan_weights(rows.weights, i, header.weight_count, 1.0, tolerance, place, scan.weight, scan.nonfinite);
  const double slope_max = static_cast<double>(kSlopeMax) * (1.0 + tolerance);
  scan.variance.offer(missing_variance(m, variance_tolerance(header.encoding)), place);
  scan.slope.offer(std::hypot(static_cast<double>(m.s), static_cast<double>(m.t)) - slope_max, place);
  scan.length.offer(glm::length(glm::dvec3(n)) - 1.0 - tolerance, place);
}

}  // namespace

MomentScan::MomentScan(const BakedHeader& header) : header_(header), texels_(std::make_unique<Texels>()) {}
MomentScan::~MomentScan() = default;

void MomentScan::add(int level, int first_row, const MomentLevel& rows) {
  std::size_t index = 0;
  for (int y = 0; y < rows.height; ++y)
    for (int x = 0; x < rows.width; ++x, ++index) scan_texel(header_, rows, index, {level, x, first_row + y}, *texels_);
}

std::vector<VerifyFinding> MomentScan::findings() const {
  std::vector<VerifyFinding> findings = {
      finite_finding(texels_->nonfinite, "non-finite texels"),
      excess_finding("variance", texels_->variance, "no variance is below 0, and no correlation exceeds 1",
                     "E[b b] contradicts E[b] by more than rounding allows,"),
      excess_finding("slope", texels_->slope, fmt::format("no mean slope exceeds {}", kSlopeMax),
                     "a mean slope is too steep"),
      excess_finding("|n| <= 1", texels_->length, "no mean normal is longer than rounding allows",
                     "a mean normal is longer than rounding allows,"),
  };
  if (header_.weight_count > 0) findings.push_back(weights_finding(header_.weight_count, texels_->weight, "1"));
  return findings;
}

std::vector<VerifyFinding> verify_moments(const std::string& path, int threads, const MomentRowsSeen& seen) {
  MomentReader reader(path, threads, TexelCheck::kReport);
  MomentScan scan(reader.header());
  return verify_by_scan(path, reader, scan, "moments", seen);
}

}  // namespace multum
