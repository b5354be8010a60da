// SPDX-License-Identifier: Apache-2.0
// Tells whether a map has the same normal everywhere. For such a map, plain averages are as good as any other method.
#pragma once

#include <string>

#include "host/formats/image/plane_store.h"

namespace multum {

enum class Flatness { kRelief, kOneNormal, kFlat };

/// Returns whether all normals are within one 8-bit step of each other, and whether they are within one step of +Z.
/// Stops reading at the first row that differs.
Flatness flatness_of(const PlaneStore& normals);

/// Returns a note for the user, or an empty text if the map is not flat.
std::string flat_note(Flatness flatness);

}  // namespace multum
