// SPDX-License-Identifier: Apache-2.0
// By the addition theorem, the coefficients of band l of one direction are on a sphere of radius sqrt((2l+1)/4pi). A
// mean of directions is therefore inside the sphere, and level 0 is on the sphere. If the width of a BRDF is included,
// level 0 is inside too. Band l = 1 of level 0 is then at c times the radius, where c is between 1/2 and 1.
#include "host/formats/asset/averages/sh_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/formats/asset/averages/sh_file.h"
#include "host/formats/asset/verify_scan.h"

namespace multum {

struct ShScan::Texels {
  std::size_t nonfinite = 0;
  WorstTexel strong, unlike, weight;  // how much values exceed their tolerances
};

namespace {

bool is_finite(const ShLevel& rows, std::size_t i) {
  for (const auto& part : rows.parts)
    for (int c = 0; c < 4; ++c)
      if (!std::isfinite(part[i][c])) return false;
  return rows.colours.empty() ||
         (std::isfinite(rows.colours[i].x) && std::isfinite(rows.colours[i].y) && std::isfinite(rows.colours[i].z));
}

// Returns the sum of squares of band l, relative to (2l+1)/4pi.
double power_of_band(const ShLevel& rows, std::size_t i, int l) {
  double sum = 0.0;
  for (int m = -l; m <= l; ++m) {
    const auto g = static_cast<double>(rows.value(sh_coefficient(l, m), i));
    sum += g * g;
  }
  return sum * 4.0 * M_PI / (2.0 * l + 1.0);
}

void scan_texel(const BakedHeader& header, int order, const ShLevel& rows, std::size_t i, TexelPlace place,
                ShScan::Texels& scan) {
  if (!is_finite(rows, i)) {
    ++scan.nonfinite;
    return;
  }
  const double tolerance = sh_power_tolerance(header.encoding);
  scan_weights(rows.weights, i, header.weight_count, 1.0, tolerance, place, scan.weight, scan.nonfinite);
  for (place.band = 1; place.band <= order; ++place.band) {
    const double excess = power_of_band(rows, i, place.band) - 1.0;
    scan.strong.offer(excess - tolerance, place);
    if (place.level > 0 || (header.has_roughness && place.band > 1)) continue;
    const double missing_max = header.has_roughness ? 0.75 : 0.0;  // 1 - c^2 for c = 1/2
    scan.unlike.offer(-excess - missing_max - tolerance, place);
  }
}

}  // namespace

ShScan::ShScan(const BakedHeader& header, int order)
    : header_(header), order_(order), texels_(std::make_unique<Texels>()) {}
ShScan::~ShScan() = default;

void ShScan::add(int level, int first_row, const ShLevel& rows) {
  std::size_t index = 0;
  for (int y = 0; y < rows.height; ++y)
    for (int x = 0; x < rows.width; ++x, ++index)
      scan_texel(header_, order_, rows, index, {level, x, first_row + y}, *texels_);
}

std::vector<VerifyFinding> ShScan::findings() const {
  std::vector<VerifyFinding> findings = {
      finite_finding(texels_->nonfinite, "non-finite texels"),
      excess_finding("power", texels_->strong,
                     "in each band, the sum of the squared coefficients is at most that of a single direction",
                     "in a band, the sum of the squared coefficients exceeds that of a single direction"),
      excess_finding(
          "level 0", texels_->unlike,
          header_.first_level > 0 ? "not stored"
          : header_.has_roughness ? "each texel holds the facets of one normal"
                                  : "each texel holds one direction",
          "a texel does not hold one direction: in a band, the sum of the squared coefficients is too small"),
  };
  if (header_.weight_count > 0) findings.push_back(weights_finding(header_.weight_count, texels_->weight, "1"));
  return findings;
}

std::vector<VerifyFinding> verify_sh(const std::string& path, int threads, const ShRowsSeen& seen) {
  ShReader reader(path, threads, TexelCheck::kReport);
  ShScan scan(reader.header(), reader.order());
  return verify_by_scan(path, reader, scan, fmt::format("spherical harmonics to order {}", reader.order()), seen);
}

}  // namespace multum
