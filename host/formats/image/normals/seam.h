// SPDX-License-Identifier: Apache-2.0
// Tells whether a map tiles: the step from its last column to its first, and from its last row to its first, beside the
// steps between neighbours inside.
#pragma once

#include "host/formats/image/normals/height_surface.h"
#include "host/formats/image/raw_image.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {

/// Steps in one direction: rms differences over the pairs of texels of two columns or rows, in the file's own numbers.
struct SeamStep {
  double border = 0.0;   // from the last to the first
  double median = 0.0;   // median of those inside
  double largest = 0.0;  // of those inside that were looked at

  /// Whether the border is a step that the map has nowhere inside. False where there are too few texels to tell.
  bool is_seam() const;
};

struct MapSeams {
  SeamStep s;  // columns
  SeamStep t;  // rows
};

/// Measures at most 512 rows, evenly spaced, each with the one below it. The second form compares heights at borders
/// with those beyond, which may be another tile's, in units of their values. Where nothing lies beyond, it finds no
/// seam.
MapSeams measure_seams(const RawImage& image);
MapSeams measure_seams(const HeightSurface& surface);

}  // namespace multum
