// SPDX-License-Identifier: Apache-2.0
// Tells whether a map has one normal everywhere, so that averages of it are as good as anything.
#pragma once

#include <string>

#include "host/formats/image/plane_store.h"

namespace multum {

enum class Flatness { kRelief, kOneNormal, kFlat };

/// Whether all normals are within a step of 8 bits of one another, and of +Z. Reads rows until one differs.
Flatness flatness_of(const PlaneStore& normals);

/// What to say of it; empty of a relief.
std::string flat_note(Flatness flatness);

}  // namespace multum
