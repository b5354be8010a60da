// SPDX-License-Identifier: Apache-2.0
// Replaces the deflate that OpenEXR calls with faster libraries; the .cpp file says why.
#pragma once

namespace multum {

/// Returns true. A call links the replacement into the program; the writer makes that call.
bool replaces_zlib_compress();

}  // namespace multum
