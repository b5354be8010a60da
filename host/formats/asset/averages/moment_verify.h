// SPDX-License-Identifier: Apache-2.0
// Checks a baked file of moments without its source: structure, checksum, finite values, lengths and variances.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/baked_verify.h"

namespace multum {

/// Receives the rows of a stored level from the top, so that callers can examine the texels without reading the file
/// twice.
using MomentRowsSeen = std::function<void(int level, int first_row, const MomentLevel& rows)>;

/// Checks rows like verify_moments(), even before they are in a file.
class MomentScan {
 public:
  explicit MomentScan(const BakedHeader& header);
  ~MomentScan();
  void add(int level, int first_row, const MomentLevel& rows);
  /// Returns the findings for all rows added so far.
  std::vector<VerifyFinding> findings() const;

  struct Texels;  // counts of texels, and the worst texels

 private:
  const BakedHeader header_;
  std::unique_ptr<Texels> texels_;
};

/// Reads the file by rows of tiles, so that only a few rows are in memory. Throws Error(kInput) if the structure is
/// unreadable. Every other failed check is a finding. Calls `seen` once for every row.
std::vector<VerifyFinding> verify_moments(const std::string& path, int threads, const MomentRowsSeen& seen = {});

}  // namespace multum
