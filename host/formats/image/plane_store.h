// SPDX-License-Identifier: Apache-2.0
// Three planes of floats by bands of rows, in memory or in a scratch file: normals (x, y, z) or linear RGB of maps that
// may be larger than memory. Row 0 on top.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/foundation/base/files/scratch_file.h"
#include "host/foundation/base/files/spill_policy.h"

namespace multum {

/// Planes in a file: from byte `begin` on, each in blocks of `rows` rows, the last of a plane with what is left, and
/// `gap` bytes behind each block. No rows: a block a plane.
struct PlaneBlocks {
  std::uint64_t begin = 0, gap = 0;
  int rows = 0;
};

class PlaneStore {
 public:
  /// In memory.
  PlaneStore(int width, int height);
  /// In a scratch file in `folder`.
  PlaneStore(int width, int height, const std::string& folder);
  /// Reads planes that `file` has, one behind the other, as `blocks` say; nothing can be written.
  PlaneStore(int width, int height, ScratchFile file, const PlaneBlocks& blocks);
  /// Looks at planes that are in memory already and must outlive it; nothing can be written.
  PlaneStore(int width, int height, const std::array<const float*, 3>& planes);

  int width() const { return width_; }
  int height() const { return height_; }
  /// Whether these are normals that a roughness map has shortened (host/formats/image/material_maps.h).
  bool is_shortened() const { return is_shortened_; }
  void set_shortened(bool is_shortened) { is_shortened_ = is_shortened; }
  /// The store must be in memory, and is empty after.
  std::array<std::vector<float>, 3> take_planes();

  /// Rows [first_row, first_row + row_count), row-major. Throws Error(kEnvironment) when the disk refuses. Threads may
  /// write different rows at once.
  void write_rows(int first_row, int row_count, const std::array<const float*, 3>& planes);
  /// Reads all planes, one of them, or all at one texel. Any number of threads may read at once.
  void read_rows(int first_row, int row_count, const std::array<float*, 3>& planes) const;
  void read_rows(int plane, int first_row, int row_count, float* rows) const;
  std::array<float, 3> texel(int column, int row) const;

 private:
  std::size_t offset(int row) const { return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_); }
  std::uint64_t offset_in_file(int plane, int row) const;
  void check_rows(int first_row, int row_count) const;

  int width_;
  int height_;
  bool is_shortened_ = false;
  // Not set to 0: the threads that write touch them first.
  std::array<std::unique_ptr<float[]>, 3> owned_;
  std::array<const float*, 3> planes_{};  // null: in the file
  std::optional<ScratchFile> file_;
  PlaneBlocks blocks_;  // of the file
};

PlaneStore make_plane_store(int width, int height, const SpillPolicy& spill);

/// Rows per band of decoding: few enough for a thread's cache, enough to be worth a hand-over.
int decoding_rows(int width, const SpillPolicy& spill);

}  // namespace multum
