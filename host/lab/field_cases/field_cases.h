// SPDX-License-Identifier: Apache-2.0
// Registers the numerical cases of the kernels for fields, which compute least squares and image transforms.
#pragma once

namespace multum {

/// Adds the cases to numerical_cases(). Call it before the first use of numerical_cases().
void register_field_cases();

}  // namespace multum
