// SPDX-License-Identifier: Apache-2.0
// The numerical cases of the kernels that fields need: least squares, transforms of images.
#pragma once

namespace multum {

/// Adds them to numerical_cases(), which nobody may have asked for yet.
void register_field_cases();

}  // namespace multum
