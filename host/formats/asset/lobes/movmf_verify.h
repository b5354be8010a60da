// SPDX-License-Identifier: Apache-2.0
// Checks a baked file without its source: structure, finite values, sums and checksums.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/formats/asset/baked_verify.h"
#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// Receives the rows of a stored level from the top, so that callers can examine the texels without reading the file
/// twice.
using MovmfRowsSeen = std::function<void(int level, int first_row, const MovmfLevel& rows)>;

/// Checks rows like verify_movmf(), even before they are in a file.
class MovmfScan {
 public:
  /// Copies `header`. The levels of `header` need no texels.
  explicit MovmfScan(const MovmfMipmap& header);
  ~MovmfScan();
  void add(int level, int first_row, const MovmfLevel& rows);
  void add_finest(int first_row, const MovmfFinest& rows);
  /// Returns the findings for all rows added so far.
  std::vector<VerifyFinding> findings() const;

 private:
  struct Lobes;
  bool has_lobes_alone() const;
  void add_texels(int level, int first_row, const MovmfLevel& rows, std::size_t begin, std::size_t end);

  const MovmfMipmap header_;
  std::unique_ptr<Lobes> lobes_;
};

/// Reads the file by rows of tiles, so that only a few rows are in memory. Throws Error(kInput) if the structure is
/// unreadable. Every other failed check is a finding. Calls `seen` once for every row.
std::vector<VerifyFinding> verify_movmf(const std::string& path, int threads, const MovmfRowsSeen& seen = {});

}  // namespace multum
