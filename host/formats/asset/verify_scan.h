// SPDX-License-Identifier: Apache-2.0
// Shares between verify_moments(), verify_sh() and verify_movmf() the search for the worst texel and the words for it.
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
  int band = -1;  // of spherical harmonics; < 0: none
};

/// The texel that exceeds what is allowed by most; at or below 0: none does.
struct WorstTexel {
  double value = 0.0;
  TexelPlace place;

  void offer(double candidate, const TexelPlace& at) {
    if (candidate > value) *this = {candidate, at};
  }
  /// "level 2, texel (3, 4)".
  std::string text() const;
};

/// `good`, or "`bad` by 1.2e-03 at level 2, texel (3, 4)".
VerifyFinding excess_finding(const std::string& check, const WorstTexel& worst, const std::string& good,
                             const std::string& bad);
VerifyFinding structure_finding(const BakedHeader& header, const std::string& kind);
/// `changed`: rows whose own checksum differs, as BakedReader names them.
VerifyFinding checksum_finding(const std::string& hash, const std::string& expected,
                               const std::vector<std::string>& changed);
VerifyFinding finite_finding(std::size_t nonfinite, const std::string& of_what);
/// `high`: "1", or what else a weight may be at most.
VerifyFinding weights_finding(int weight_count, const WorstTexel& worst, const std::string& high);

/// Weights of texel `index`, `count` of them, each 0 to `high` but for a tolerance.
void scan_weights(const std::vector<float>& weights, std::size_t index, int count, double high, double tolerance,
                  const TexelPlace& place, WorstTexel& worst, std::size_t& nonfinite);

/// Hands out every row of every stored level, by bands of a tile's rows: `seen(level, first row, rows)`.
template <typename Reader, typename Seen>
void for_each_rows(Reader& reader, const Seen& seen) {
  const BakedHeader& header = reader.header();
  for (int l = header.first_level; l < header.level_count(); ++l) {
    const int height = mip_level_size(header.height, l);
    for (int row = 0; row < height; row += reader.tile_size())
      seen(l, row, reader.read_level(l, row, std::min(reader.tile_size(), height - row)));
  }
}

/// Verifies a file of averages: scans every row by `scan`, hands it to `seen` where that is set, and lists structure,
/// checksum, header and what the scan found. `kind`: "moments".
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
