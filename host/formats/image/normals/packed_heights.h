// SPDX-License-Identifier: Apache-2.0
// Recognises heights whose bytes are spread over the 8-bit channels of a picture.
#pragma once

#include <optional>

#include "host/formats/image/normals/height_surface.h"

namespace multum {

/// The coding whose heights are continuous where the channels by themselves are not; nullopt where there is none. Looks
/// at 128 rows at most.
std::optional<HeightCoding> find_packed_heights(const RawImage& image);

}  // namespace multum
