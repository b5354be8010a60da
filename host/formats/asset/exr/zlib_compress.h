// SPDX-License-Identifier: Apache-2.0
// Replaces the deflate function that OpenEXR calls with functions of faster libraries. The .cpp file gives the reasons.
#pragma once

namespace multum {

/// Returns true. The replacement is linked only if a program contains a call of this function. The writer makes that
/// call.
bool replaces_zlib_compress();

}  // namespace multum
