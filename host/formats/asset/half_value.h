// SPDX-License-Identifier: Apache-2.0
// The largest half float, and a function that rounds to the nearest half. Only host/formats/asset uses this file.
#pragma once

#include <half.h>

namespace multum {

constexpr float kHalfMax = 65504.0f;

/// Rounds to the nearest half.
inline float as_half(float value) { return static_cast<float>(half(value)); }

}  // namespace multum
