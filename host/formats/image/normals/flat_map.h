// SPDX-License-Identifier: Apache-2.0
// Tells whether a map has the same normal everywhere; for such a map, plain averages are as good as any method.
#pragma once

#include <string>

#include "host/formats/image/plane_store.h"

namespace multum {

enum class Flatness { kRelief, kOneNormal, kFlat };

/// Returns whether all normals are within one 8-bit step of each other, and of +Z. Stops reading at the first row that
/// differs.
Flatness flatness_of(const PlaneStore& normals);

/// Returns a note for the user; empty for a relief.
std::string flat_note(Flatness flatness);

}  // namespace multum
