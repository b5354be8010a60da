// SPDX-License-Identifier: Apache-2.0
// Checks a baked file of spherical harmonics without its source: structure, checksum, finite values, and the strength
// of each band. A band of a mean of directions cannot be stronger than the same band of a single direction.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/baked_verify.h"

namespace multum {

/// Receives the rows of a stored level from the top, so that callers can examine the texels without reading the file
/// twice.
using ShRowsSeen = std::function<void(int level, int first_row, const ShLevel& rows)>;

/// Checks rows like verify_sh(), even before they are in a file.
class ShScan {
 public:
  explicit ShScan(const BakedHeader& header, int order);
  ~ShScan();
  void add(int level, int first_row, const ShLevel& rows);
  /// Returns the findings for all rows added so far.
  std::vector<VerifyFinding> findings() const;

  struct Texels;  // counts of texels, and the worst texels

 private:
  const BakedHeader header_;
  const int order_;
  std::unique_ptr<Texels> texels_;
};

/// Reads the file by rows of tiles, so that only a few rows are in memory. Throws Error(kInput) if the structure is
/// unreadable. Every other failed check is a finding. Calls `seen` once for every row.
std::vector<VerifyFinding> verify_sh(const std::string& path, int threads, const ShRowsSeen& seen = {});

}  // namespace multum
