// SPDX-License-Identifier: Apache-2.0
// Checks a baked file by itself, without its source: structure, finite values, sums, checksums.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/formats/asset/baked_verify.h"
#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// Rows of a stored level, from the top: what else wants to look at the texels needs no second reading.
using MovmfRowsSeen = std::function<void(int level, int first_row, const MovmfLevel& rows)>;

/// Checks rows as verify_movmf() does, also before they are in a file.
class MovmfScan {
 public:
  /// `header`: without texels; it need not outlive this.
  explicit MovmfScan(const MovmfMipmap& header);
  ~MovmfScan();
  void add(int level, int first_row, const MovmfLevel& rows);
  void add_finest(int first_row, const MovmfFinest& rows);
  /// Findings of all rows that were added.
  std::vector<VerifyFinding> findings() const;

 private:
  struct Lobes;
  bool has_lobes_alone() const;
  void add_texels(int level, int first_row, const MovmfLevel& rows, std::size_t begin, std::size_t end);

  const MovmfMipmap header_;
  std::unique_ptr<Lobes> lobes_;
};

/// Reads row of tiles by row of tiles: some are in memory, never the file. Throws Error(kInput) when the file cannot be
/// read at all (structure); every other check is a finding. `seen` is told every row once.
std::vector<VerifyFinding> verify_movmf(const std::string& path, int threads, const MovmfRowsSeen& seen = {});

}  // namespace multum
