// SPDX-License-Identifier: Apache-2.0
// Tells whether a map tiles. Compares the steps between opposite borders with the steps between neighbours inside.
#pragma once

#include "host/formats/image/normals/height_surface.h"
#include "host/formats/image/raw_image.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {

/// Steps in one direction. A step is the rms difference between two columns or rows, in the file's own numbers.
struct SeamStep {
  double border = 0.0;   // step from the last column or row to the first
  double median = 0.0;   // median of the steps inside the map
  double largest = 0.0;  // largest of the examined steps inside the map

  /// Returns whether the step at the border is larger than every step inside. Returns false if there are too few texels
  /// for a decision.
  bool is_seam() const;
};

struct MapSeams {
  SeamStep s;  // between columns
  SeamStep t;  // between rows
};

/// Measures at most 512 rows, evenly spaced, each with the row below. The second function compares heights at the
/// borders with heights beyond the borders, which can belong to another tile. Its results have the unit of the heights.
/// If there are no heights beyond a border, it finds no seam.
MapSeams measure_seams(const RawImage& image);
MapSeams measure_seams(const HeightSurface& surface);

}  // namespace multum
