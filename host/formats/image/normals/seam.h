// SPDX-License-Identifier: Apache-2.0
// Tells whether a map tiles, by comparing the steps between opposite borders with the steps between neighbours inside.
#pragma once

#include "host/formats/image/normals/height_surface.h"
#include "host/formats/image/raw_image.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {

/// Steps in one direction: rms differences between two columns or rows, in the file's own numbers.
struct SeamStep {
  double border = 0.0;   // step from the last to the first
  double median = 0.0;   // median of the steps inside
  double largest = 0.0;  // largest of the examined steps inside

  /// Returns whether the step at the border is larger than any inside. Returns false if there are too few texels for a
  /// decision.
  bool is_seam() const;
};

struct MapSeams {
  SeamStep s;  // columns
  SeamStep t;  // rows
};

/// Measures at most 512 rows, evenly spaced, each with the row below. The second form compares heights at the borders
/// with heights beyond the borders, which can belong to another tile, in the unit of their values. If there are no
/// heights beyond a border, it finds no seam.
MapSeams measure_seams(const RawImage& image);
MapSeams measure_seams(const HeightSurface& surface);

}  // namespace multum
