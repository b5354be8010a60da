// SPDX-License-Identifier: Apache-2.0
// Checks a baked file of spherical harmonics by itself, without its source: structure, checksum, finite values, and
// bands no stronger than those of one direction.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/baked_verify.h"

namespace multum {

/// Rows of a stored level, from the top: what else wants to look at the texels needs no second reading.
using ShRowsSeen = std::function<void(int level, int first_row, const ShLevel& rows)>;

/// Checks rows as verify_sh() does, also before they are in a file.
class ShScan {
 public:
  explicit ShScan(const BakedHeader& header, int order);
  ~ShScan();
  void add(int level, int first_row, const ShLevel& rows);
  /// Findings of all rows that were added.
  std::vector<VerifyFinding> findings() const;

  struct Texels;  // what was found

 private:
  const BakedHeader header_;
  const int order_;
  std::unique_ptr<Texels> texels_;
};

/// Reads row of tiles by row of tiles: some are in memory, never the file. Throws Error(kInput) when the file cannot be
/// read at all (structure); every other check is a finding. `seen` is told every row once.
std::vector<VerifyFinding> verify_sh(const std::string& path, int threads, const ShRowsSeen& seen = {});

}  // namespace multum
