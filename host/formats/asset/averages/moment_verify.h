// SPDX-License-Identifier: Apache-2.0
// Checks a baked file of moments by itself, without its source: structure, checksum, finite values, lengths, variances.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/baked_verify.h"

namespace multum {

/// Rows of a stored level, from the top: what else wants to look at the texels needs no second reading.
using MomentRowsSeen = std::function<void(int level, int first_row, const MomentLevel& rows)>;

/// Checks rows as verify_moments() does, also before they are in a file.
class MomentScan {
 public:
  explicit MomentScan(const BakedHeader& header);
  ~MomentScan();
  void add(int level, int first_row, const MomentLevel& rows);
  /// Findings of all rows that were added.
  std::vector<VerifyFinding> findings() const;

  struct Texels;  // what was found

 private:
  const BakedHeader header_;
  std::unique_ptr<Texels> texels_;
};

/// Reads row of tiles by row of tiles: some are in memory, never the file. Throws Error(kInput) when the file cannot be
/// read at all (structure); every other check is a finding. `seen` is told every row once.
std::vector<VerifyFinding> verify_moments(const std::string& path, int threads, const MomentRowsSeen& seen = {});

}  // namespace multum
