// SPDX-License-Identifier: Apache-2.0
// Stores three planes of floats in memory or in a scratch file. The planes are accessed in bands of rows. They hold
// normals (x, y, z) or linear RGB of maps that can be larger than memory. Row 0 is at the top.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/foundation/base/files/scratch_file.h"
#include "host/foundation/base/files/spill_policy.h"

namespace multum {

/// Planes in a file from byte `begin` on. Each plane consists of blocks of `rows` rows (the last may have fewer), with
/// `gap` bytes after each block. rows = 0 means one block per plane.
struct PlaneBlocks {
  std::uint64_t begin = 0, gap = 0;
  int rows = 0;
};

class PlaneStore {
 public:
  /// Makes a store in memory.
  PlaneStore(int width, int height);
  /// Makes a store in a scratch file in `folder`.
  PlaneStore(int width, int height, const std::string& folder);
  /// Reads planes that are stored in `file` one after another, in the layout of `blocks`. The store is read-only.
  PlaneStore(int width, int height, ScratchFile file, const PlaneBlocks& blocks);
  /// Refers to planes in memory, which must outlive the store. The store is read-only.
  PlaneStore(int width, int height, const std::array<const float*, 3>& planes);

  int width() const { return width_; }
  int height() const { return height_; }
  /// Returns whether these are normals whose lengths include the roughness of a map
  /// (host/formats/image/material_maps.h).
  bool is_shortened() const { return is_shortened_; }
  void set_shortened(bool is_shortened) { is_shortened_ = is_shortened; }
  /// Moves the planes out of the store. The store must be in memory, and is empty afterwards.
  std::array<std::vector<float>, 3> take_planes();

  /// Writes rows [first_row, first_row + row_count) in row-major order. Throws Error(kEnvironment) if the disk fails.
  /// Several threads may write different rows at once.
  void write_rows(int first_row, int row_count, const std::array<const float*, 3>& planes);
  /// Read all planes, one plane, or one texel of all planes. Several threads may read at the same time.
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
  // The memory of the planes. The memory is not initialized to 0, so that the writing threads touch it first.
  std::array<std::unique_ptr<float[]>, 3> owned_;
  std::array<const float*, 3> planes_{};  // null if the planes are in the file
  std::optional<ScratchFile> file_;
  PlaneBlocks blocks_;  // layout of the file
};

PlaneStore make_plane_store(int width, int height, const SpillPolicy& spill);

/// Returns the number of rows per band for decoding. Bands are small enough for a thread's cache, but large enough to
/// justify the cost of scheduling them.
int decoding_rows(int width, const SpillPolicy& spill);

}  // namespace multum
