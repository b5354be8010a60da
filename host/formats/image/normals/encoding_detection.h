// SPDX-License-Identifier: Apache-2.0
// Detects the meaning of the values of an image from their statistics: height field or normal map, signed or 0..1, two
// or three channels, green up or down. The answer includes its reason. A file that is neither a height field nor a
// normal map is rejected, and the message gives the reason.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/image/normals/height_surface.h"
#include "host/formats/image/normals/image_survey.h"
#include "host/formats/image/normals/normal_decode.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/raw_image.h"

namespace multum {

struct DetectedEncoding {
  bool is_height_field = false;
  HeightReading heights;              // reading of a height field
  VectorEncoding vectors;             // encoding of a normal map
  std::string description;            // NormalMapReport::encoding of a normal map
  std::string reason;                 // NormalMapReport::encoding_reason
  std::vector<std::string> warnings;  // NormalMapReport::warnings
};

/// Returns the encodings whose statistics detect_encoding() will probably need, according to the information that is
/// known before rows are read. The survey of the image should collect these statistics.
std::vector<VectorEncoding> likely_encodings(const RawImageInfo& info, const NormalMapSettings& settings);

/// Returns whether an image is grey, up to compression noise.
bool is_grey_image(const RawImageInfo& info, const ImageSurvey& survey);

/// Returns the direction of green (up or down) of a set of tiles, given the direction found in this map. Returns
/// nullopt if the direction is unknown.
using GreenOfSet = std::function<std::optional<GreenAxis>(std::optional<GreenAxis> own)>;

/// Follows the overrides in `settings`. Throws Error(kInput) with the reason if the file is neither a normal map nor a
/// height field, unless settings.bump_format states its kind.
DetectedEncoding detect_encoding(const std::string& path, const RawImage& image, const ImageSurvey& survey,
                                 const NormalMapSettings& settings, int threads, const GreenOfSet& green_of_set = {});

}  // namespace multum
