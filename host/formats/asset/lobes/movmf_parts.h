// SPDX-License-Identifier: Apache-2.0
// Lists the parts of a baked file in order, with their channels and levels. Writer, reader and checksum use the same
// list (docs/reference/file_format.md, "Parts and channels"). Only host/formats/asset uses this file.
#pragma once

#include <vector>

#include "host/formats/asset/baked_header.h"
#include "host/formats/asset/exr/exr_rows.h"
#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

enum class MovmfPartKind { kFinest, kLobe, kColour, kWeights };

struct MovmfPart : BakedPart {
  MovmfPartKind kind;
  int lobe;  // index of the lobe; unused for kFinest

  /// Returns the first value of a level's rows; not valid for kFinest.
  const float* values(const MovmfLevel& rows) const;
  float* values(MovmfLevel& rows) const;
};

/// Returns the parts of a mipmap. The mipmap does not need to have texels.
std::vector<MovmfPart> movmf_parts(const MovmfMipmap& header);

/// Interleaves texels of the part "finest" in stored order: R, G and B if the map has colours; lobe; x; y; z if the map
/// has roughness; weights.
void interleave(const MovmfFinest& rows, std::size_t first_texel, std::size_t count, float* values);

}  // namespace multum
