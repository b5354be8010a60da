// SPDX-License-Identifier: Apache-2.0
// Computes the normals of height fields, the surfaces (x, y, height), by central differences. The differences are
// one-sided where the surface ends.
#pragma once

#include <cstdint>
#include <string>

#include "host/formats/image/normals/height_surface.h"
#include "host/formats/image/normals/normal_map.h"

namespace multum {

/// A height field in an image. The image must outlive this object.
struct HeightField {
  const RawImage& image;
  HeightReading reading;
  std::int64_t nonfinite_count = 0;  // texels repaired by NormalMapSettings::fix_nan
  HeightSides sides;
};

/// Fills in the counts, warnings and encoding of the report. The encoding states the rms slope, which reveals a wrong
/// height_scale. Texels without a height are flat and counted as unused. Warns about terraces, and smooths them if
/// settings.dequantize is set. Throws and cancels like decode_normals().
NormalMapRows normals_from_heights(const std::string& path, const HeightField& field, const NormalMapSettings& settings,
                                   const SpillPolicy& spill, int threads, Progress* progress);

}  // namespace multum
