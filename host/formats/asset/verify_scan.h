// SPDX-License-Identifier: Apache-2.0
// Finds the worst texel and describes it, for verify_moments(), verify_sh() and verify_movmf().
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host/formats/asset/baked_file.h"
#include "host/formats/asset/baked_verify.h"
#include "host/formats/asset/header_hash.h"

namespace multum {

struct TexelPlace {
  int level = 0, x = 0, y = 0;
  int band = -1;  // band of spherical harmonics; negative for other representations
};

/// The texel with the largest excess over the tolerance. If `value` <= 0, no texel exceeds the tolerance.
struct WorstTexel {
  double value = 0.0;
  TexelPlace place;

  void offer(double candidate, const TexelPlace& at) {
    if (candidate > value) *this = {candidate, at};
  }
  /// Returns "level 2, texel (3, 4)".
  std::string text() const;
};

/// Returns a finding. Its detail is `good` if it passes; otherwise "`bad` by 1.2e-03 at level 2, texel (3, 4)".
VerifyFinding excess_finding(const std::string& check, const WorstTexel& worst, const std::string& good,
                             const std::string& bad);
VerifyFinding structure_finding(const BakedHeader& header, const std::string& kind);
/// `changed` lists the rows that have a wrong checksum, as BakedReader describes them.
VerifyFinding checksum_finding(const std::string& hash, const std::string& expected,
                               const std::vector<std::string>& changed);
VerifyFinding finite_finding(std::size_t nonfinite, const std::string& of_what);
/// `high` names a weight's upper limit, such as "1".
VerifyFinding weights_finding(int weight_count, const WorstTexel& worst, const std::string& high);

/// Checks the `count` weights of texel `index`. Each must be from 0 to `high`, within a tolerance.
void scan_weights(const std::vector<float>& weights, std::size_t index, int count, double high, double tolerance,
                  const TexelPlace& place, WorstTexel& worst, std::size_t& nonfinite);

/// Calls `seen(level, first row, rows)` for bands of the height of a tile, until it has seen every row of every stored
/// level.
template <typename Reader, typename Seen>
void for_each_rows(Reader& reader, const Seen& seen) {
  const BakedHeader& header = reader.header();
  for (int l = header.first_level; l < header.level_count(); ++l) {
    const int height = mip_level_size(header.height, l);
    for (int row = 0; row < height; row += reader.tile_size())
      seen(l, row, reader.read_level(l, row, std::min(reader.tile_size(), height - row)));
  }
}

/// Verifies a file of averages. Scans every row with `scan`, and also passes it to `seen` if that is set. Returns the
/// findings on structure, checksum and header, and the findings of the scan. `kind` is, for example, "moments".
template <typename Reader, typename Scan, typename Seen>
std::vector<VerifyFinding> verify_by_scan(const std::string& path, Reader& reader, Scan& scan, const std::string& kind,
                                          const Seen& seen) {
  for_each_rows(reader, [&](int level, int first_row, const auto& rows) {
    scan.add(level, first_row, rows);
    if (seen) seen(level, first_row, rows);
  });
  const BakedHeader& header = reader.header();
  std::vector<VerifyFinding> findings = {
      structure_finding(header, kind),
      checksum_finding(reader.finish_hash(), header.provenance.content_hash, reader.changed_rows()),
      header_finding(path)};
  for (VerifyFinding& finding : scan.findings()) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace multum
