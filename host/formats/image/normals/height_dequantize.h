// SPDX-License-Identifier: Apache-2.0
// Smooths heights that have too few bits. Among all surfaces that round to the given heights, finds the surface with
// the smallest bending.
#pragma once

#include "host/formats/image/normals/height_surface.h"
#include "host/foundation/base/files/spill_policy.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// The number of known texels beyond the sides of the image that are used.
constexpr int kDequantizeMargin = 128;

/// Returns heights with one more row and column on each side, like HeightSurface::rows() with a margin of 1. Texel
/// (column, row) is at (column + 1, row + 1). Each height is within `step` / 2 of the given height, or NaN if there is
/// no height. A difference of more than 1.5 steps between neighbours is an edge, which stays sharp. The result does not
/// depend on `threads` or `spill`. The work can be cancelled between tiles.
RawImage dequantized_heights(const HeightSurface& surface, double step, const SpillPolicy& spill, int threads,
                             Progress* progress);

}  // namespace multum
