// SPDX-License-Identifier: Apache-2.0
// By the addition theorem the coefficients of band l of one direction lie on a sphere of radius sqrt((2l+1)/4pi), so
// that those of a mean of directions lie within it, and those of level 0 on it.
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
  Worst strong, unlike;  // how far beyond what is allowed
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
            if (l == 0) scan.unlike.offer(-excess - tolerance, l, x, row + y, band);
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
  return {
      {"structure", true,
       fmt::format("{} x {}, {}, spherical harmonics to order {}{}, encoding {}", header.width, header.height,
                   levels_text(header.first_level, header.level_count()), reader.order(),
                   header.has_colours ? " with colours" : "", storage_encoding_name(header.encoding))},
      {"checksum", is_same,
       is_same ? hash : "found " + hash + ", expected " + header.provenance.content_hash + " as the header says"},
      {"finite", scan.nonfinite == 0, fmt::format("{} texels that are not finite, expected 0", scan.nonfinite)},
      finding("power", scan.strong, "no band is stronger than that of one direction",
              "a band is stronger than that of one direction"),
      finding("level 0", scan.unlike, header.first_level == 0 ? "each texel is one direction" : "not stored",
              "a texel is not one direction: a band is weaker"),
  };
}

}  // namespace multum
