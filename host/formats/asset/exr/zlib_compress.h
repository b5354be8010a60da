// SPDX-License-Identifier: Apache-2.0
// Replaces the deflate function that OpenEXR calls with faster libraries; the .cpp file gives the reasons.
#pragma once

namespace multum {

/// Returns true. If a program contains a call of this function, the replacement is linked. The writer makes that call.
bool replaces_zlib_compress();

}  // namespace multum
