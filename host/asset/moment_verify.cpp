// SPDX-License-Identifier: Apache-2.0
#include "host/asset/moment_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/asset/moment_file.h"

namespace multum {
namespace {

// What rounding allows: of a variance or covariance, of the moment itself; of lengths, absolutely (docs/FORMAT.md).
// Rounding down takes a whole step of the square, 2^-10 of it; averaging in float some 2^-24.
double variance_tolerance(StorageEncoding encoding) { return encoding == StorageEncoding::kHalf ? 1.05e-3 : 2e-6; }
double length_tolerance(StorageEncoding encoding) { return encoding == StorageEncoding::kHalf ? 2e-3 : 1e-6; }

struct Worst {
  double value = 0.0;
  int level = 0, x = 0, y = 0;
  void offer(double candidate, int at_level, int at_x, int at_y) {
    if (candidate > value) *this = {candidate, at_level, at_x, at_y};
  }
  std::string text() const { return fmt::format("level {}, texel ({}, {})", level, x, y); }
};

struct Scan {
  std::size_t nonfinite = 0;
  Worst variance, slope, length, weight;  // how far beyond what is allowed
};

bool is_finite(const float* values, int count) {
  return std::all_of(values, values + count, [](float value) { return std::isfinite(value); });
}

// How far a second moment is below what its means' product allows; of the covariance, beyond Cauchy and Schwarz.
double missing_variance(const SlopeMoments& m, double tolerance) {
  constexpr double kLeastStep = 6e-8;  // of halfs near zero
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

void scan_texel(const BakedHeader& header, const MomentLevel& rows, std::size_t i, int l, int x, int y, Scan& scan) {
  const SlopeMoments& m = rows.slopes[i];
  const glm::vec3& n = rows.normals[i];
  if (!is_finite(&m.height, 6) || !is_finite(&n.x, 3) || (!rows.colours.empty() && !is_finite(&rows.colours[i].x, 3))) {
    ++scan.nonfinite;
    return;
  }
  const std::size_t weight_count = static_cast<std::size_t>(header.weight_count);
  for (std::size_t k = i * weight_count; k < (i + 1) * weight_count; ++k) {
    const auto weight = static_cast<double>(rows.weights[k]);
    if (!std::isfinite(weight)) ++scan.nonfinite;
    else scan.weight.offer(std::max(-weight, weight - 1.0 - length_tolerance(header.encoding)), l, x, y);
  }
  const double slope_max = static_cast<double>(kSlopeMax) * (1.0 + length_tolerance(header.encoding));
  scan.variance.offer(missing_variance(m, variance_tolerance(header.encoding)), l, x, y);
  scan.slope.offer(std::hypot(static_cast<double>(m.s), static_cast<double>(m.t)) - slope_max, l, x, y);
  scan.length.offer(glm::length(glm::dvec3(n)) - 1.0 - length_tolerance(header.encoding), l, x, y);
}

void scan_file(MomentReader& reader, const MomentRowsSeen& seen, Scan& scan) {
  const BakedHeader& header = reader.header();
  for (int l = header.first_level; l < header.level_count(); ++l) {
    const int height = mip_level_size(header.height, l);
    for (int row = 0; row < height; row += reader.tile_size()) {
      const MomentLevel rows = reader.read_level(l, row, std::min(reader.tile_size(), height - row));
      for (int y = 0; y < rows.height; ++y)
        for (int x = 0; x < rows.width; ++x)
          scan_texel(header, rows,
                     static_cast<std::size_t>(y) * static_cast<std::size_t>(rows.width) + static_cast<std::size_t>(x),
                     l, x, row + y, scan);
      if (seen) seen(l, row, rows);
    }
  }
}

VerifyFinding finding(const std::string& check, const Worst& worst, const std::string& good, const std::string& bad) {
  const bool passed = worst.value <= 0.0;
  return {check, passed, passed ? good : fmt::format("{} by {:.2e} at {}", bad, worst.value, worst.text())};
}

}  // namespace

std::vector<VerifyFinding> verify_moments(const std::string& path, int threads, const MomentRowsSeen& seen) {
  MomentReader reader(path, threads);
  const BakedHeader& header = reader.header();
  Scan scan;
  scan_file(reader, seen, scan);
  const std::string hash = reader.finish_hash();
  const bool is_same = hash == header.provenance.content_hash;
  std::vector<VerifyFinding> findings = {
      {"structure", true,
       fmt::format("{} x {}, {}, moments{}, encoding {}", header.width, header.height,
                   levels_text(header.first_level, header.level_count()), materials_text(header),
                   storage_encoding_name(header.encoding))},
      {"checksum", is_same,
       is_same ? hash : "found " + hash + ", expected " + header.provenance.content_hash + " as the header says"},
      {"finite", scan.nonfinite == 0, fmt::format("{} texels that are not finite, expected 0", scan.nonfinite)},
      finding("variance", scan.variance, "no variance below 0, no correlation beyond 1",
              "E[b b] contradicts E[b] beyond rounding"),
      finding("slope", scan.slope, fmt::format("no mean slope above {}", kSlopeMax), "a mean slope is too steep"),
      finding("|n| <= 1", scan.length, "no mean normal is longer than rounding allows",
              "a mean normal is longer than rounding allows"),
  };
  if (header.weight_count > 0)
    findings.push_back(finding("weights", scan.weight, fmt::format("{} a texel, each from 0 to 1", header.weight_count),
                               "a weight is outside 0 to 1"));
  return findings;
}

}  // namespace multum
