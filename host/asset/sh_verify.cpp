// SPDX-License-Identifier: Apache-2.0
// By the addition theorem the coefficients of band l of one direction lie on a sphere of radius sqrt((2l+1)/4pi), so
// that those of a mean of directions lie within it, and those of level 0 on it. With a BRDF's width in they lie within
// it too, those of l = 1 at c = 1/2 to 1 of it.
#include "host/asset/sh_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/asset/sh_file.h"

namespace multum {
namespace {

struct Worst {
  double value = 0.0;
  int level = 0, x = 0, y = 0, band = 0;
  void offer(double candidate, int at_level, int at_x, int at_y, int at_band) {
    if (candidate > value) *this = {candidate, at_level, at_x, at_y, at_band};
  }
  std::string text() const { return fmt::format("level {}, texel ({}, {}), band {}", level, x, y, band); }
};

struct Scan {
  std::size_t nonfinite = 0;
  Worst strong, unlike, weight;  // how far beyond what is allowed
};

bool is_finite(const ShLevel& rows, std::size_t i) {
  for (const auto& part : rows.parts)
    for (int c = 0; c < 4; ++c)
      if (!std::isfinite(part[i][c])) return false;
  return rows.colours.empty() ||
         (std::isfinite(rows.colours[i].x) && std::isfinite(rows.colours[i].y) && std::isfinite(rows.colours[i].z));
}

// Of (2l+1)/4pi.
double power_of_band(const ShLevel& rows, std::size_t i, int l) {
  double sum = 0.0;
  for (int m = -l; m <= l; ++m) {
    const auto g = static_cast<double>(rows.value(sh_coefficient(l, m), i));
    sum += g * g;
  }
  return sum * 4.0 * M_PI / (2.0 * l + 1.0);
}

void scan_file(ShReader& reader, const ShRowsSeen& seen, Scan& scan) {
  const BakedHeader& header = reader.header();
  const double tolerance = sh_power_tolerance(header.encoding);
  for (int l = header.first_level; l < header.level_count(); ++l) {
    const int height = mip_level_size(header.height, l);
    for (int row = 0; row < height; row += reader.tile_size()) {
      const ShLevel rows = reader.read_level(l, row, std::min(reader.tile_size(), height - row));
      for (int y = 0; y < rows.height; ++y)
        for (int x = 0; x < rows.width; ++x) {
          const std::size_t i =
              static_cast<std::size_t>(y) * static_cast<std::size_t>(rows.width) + static_cast<std::size_t>(x);
          if (!is_finite(rows, i)) {
            ++scan.nonfinite;
            continue;
          }
          for (int band = 1; band <= reader.order(); ++band) {
            const double excess = power_of_band(rows, i, band) - 1.0;
            scan.strong.offer(excess - tolerance, l, x, row + y, band);
            if (l > 0 || (header.has_roughness && band > 1)) continue;
            const double missing_max = header.has_roughness ? 0.75 : 0.0;  // 1 - c^2
            scan.unlike.offer(-excess - missing_max - tolerance, l, x, row + y, band);
          }
          const auto weight_count = static_cast<std::size_t>(header.weight_count);
          for (std::size_t k = i * weight_count; k < (i + 1) * weight_count; ++k) {
            const auto weight = static_cast<double>(rows.weights[k]);
            if (!std::isfinite(weight)) ++scan.nonfinite;
            else scan.weight.offer(std::max(-weight, weight - 1.0 - tolerance), l, x, row + y, 0);
          }
        }
      if (seen) seen(l, row, rows);
    }
  }
}

VerifyFinding finding(const std::string& check, const Worst& worst, const std::string& good, const std::string& bad) {
  const bool passed = worst.value <= 0.0;
  return {check, passed, passed ? good : fmt::format("{} by {:.2e} at {}", bad, worst.value, worst.text())};
}

}  // namespace

std::vector<VerifyFinding> verify_sh(const std::string& path, int threads, const ShRowsSeen& seen) {
  ShReader reader(path, threads);
  const BakedHeader& header = reader.header();
  Scan scan;
  scan_file(reader, seen, scan);
  const std::string hash = reader.finish_hash();
  const bool is_same = hash == header.provenance.content_hash;
  std::vector<VerifyFinding> findings = {
      {"structure", true,
       fmt::format("{} x {}, {}, spherical harmonics to order {}{}, encoding {}", header.width, header.height,
                   levels_text(header.first_level, header.level_count()), reader.order(), materials_text(header),
                   storage_encoding_name(header.encoding))},
      {"checksum", is_same,
       is_same ? hash : "found " + hash + ", expected " + header.provenance.content_hash + " as the header says"},
      {"finite", scan.nonfinite == 0, fmt::format("{} texels that are not finite, expected 0", scan.nonfinite)},
      finding("power", scan.strong, "no band is stronger than that of one direction",
              "a band is stronger than that of one direction"),
      finding("level 0", scan.unlike,
              header.first_level > 0 ? "not stored"
              : header.has_roughness ? "each texel is the facets of one normal"
                                     : "each texel is one direction",
              "a texel is not one direction: a band is weaker"),
  };
  if (header.weight_count > 0)
    findings.push_back(finding("weights", scan.weight, fmt::format("{} a texel, each from 0 to 1", header.weight_count),
                               "a weight is outside 0 to 1"));
  return findings;
}

}  // namespace multum
