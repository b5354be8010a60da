// SPDX-License-Identifier: Apache-2.0
// Replaces the inflate function that OpenEXR calls with one of a faster library. The .cpp file gives the reasons.
#pragma once

namespace multum {

/// Returns true. The replacement is linked only if a program contains a call of this function. The code that opens
/// images makes that call.
bool replaces_zlib_uncompress();

}  // namespace multum
