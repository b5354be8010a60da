// SPDX-License-Identifier: Apache-2.0
// Largest half float, and rounding to the nearest half. Only host/formats/asset uses this header.
#pragma once

#include <half.h>

namespace multum {

constexpr float kHalfMax = 65504.0f;

/// Rounds to the nearest half.
inline float as_half(float value) { return static_cast<float>(half(value)); }

}  // namespace multum
