// SPDX-License-Identifier: Apache-2.0
// Replaces the inflate that OpenEXR calls with a faster library; the .cpp file gives the reasons.
#pragma once

namespace multum {

/// Returns true. If a program contains a call of this function, the replacement is linked. The code that opens images
/// makes that call.
bool replaces_zlib_uncompress();

}  // namespace multum
