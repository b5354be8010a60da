// SPDX-License-Identifier: Apache-2.0
// Recognises heights whose bytes are spread over the 8-bit channels of a picture.
#pragma once

#include <optional>

#include "host/formats/image/normals/height_surface.h"

namespace multum {

/// Returns the coding that gives continuous heights although the single channels are not continuous. Returns nullopt if
/// there is no such coding. Examines at most 128 rows.
std::optional<HeightCoding> find_packed_heights(const RawImage& image);

}  // namespace multum
