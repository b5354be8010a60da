// SPDX-License-Identifier: Apache-2.0
// Lists the parts of a baked file in order, with their channels and levels: writer, reader and checksum agree by it
// (docs/reference/file_format.md, "Parts and channels"). For host/formats/asset alone.
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
  int lobe;  // of the others

  /// The first value of a level's rows; not of kFinest.
  const float* values(const MovmfLevel& rows) const;
  float* values(MovmfLevel& rows) const;
};

/// Parts of a mipmap with or without texels.
std::vector<MovmfPart> movmf_parts(const MovmfMipmap& header);

/// Texels of the part "finest" as values lie there, interleaved: R, G, B where there are colours, lobe, x, y, z with
/// roughness, weights.
void interleave(const MovmfFinest& rows, std::size_t first_texel, std::size_t count, float* values);

}  // namespace multum
