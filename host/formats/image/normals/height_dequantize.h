// SPDX-License-Identifier: Apache-2.0
// Heights of too few bits made smooth again: of all heights that round to the ones found, those of the surface that
// bends least.
#pragma once

#include "host/formats/image/normals/height_surface.h"
#include "host/foundation/base/files/spill_policy.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Texels beyond the image's sides that are taken into account, where they are known.
constexpr int kDequantizeMargin = 128;

/// Heights with one more row and column on each side, as HeightSurface::rows() gives them with a margin of 1: texel
/// (column, row) is at (column + 1, row + 1). Each is within `step` / 2 of the one found, NaN where there is none.
/// Neighbours that differ by more than 1.5 steps are an edge, which stays as sharp as it is. The result depends neither
/// on `threads` nor on `spill`. Cancels between tiles.
RawImage dequantized_heights(const HeightSurface& surface, double step, const SpillPolicy& spill, int threads,
                             Progress* progress);

}  // namespace multum
