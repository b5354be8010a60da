// SPDX-License-Identifier: Apache-2.0
// Height fields: the normal of the surface (x, y, height) by central differences, one-sided where it ends.
#pragma once

#include <cstdint>
#include <string>

#include "host/formats/image/normals/height_surface.h"
#include "host/formats/image/normals/normal_map.h"

namespace multum {

/// A height field in an image, which must outlive it.
struct HeightField {
  const RawImage& image;
  HeightReading reading;
  std::int64_t nonfinite_count = 0;  // texels that are repaired by NormalMapSettings::fix_nan
  HeightSides sides;
};

/// Fills the report's counts, its encoding (with the rms slope: a wrong height_scale shows there) and its warnings.
/// Texels without a height are flat and counted as unused. Terraces are warned of, and smoothed where
/// settings.dequantize asks for it. Throws and cancels as decode_normals() does.
NormalMapRows normals_from_heights(const std::string& path, const HeightField& field, const NormalMapSettings& settings,
                                   const SpillPolicy& spill, int threads, Progress* progress);

}  // namespace multum
