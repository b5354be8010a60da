// SPDX-License-Identifier: Apache-2.0
// Replaces the deflate function that OpenEXR calls by faster libraries; the .cpp file gives the reasons.
#pragma once

namespace multum {

/// Returns true. A call links the replacement into the program; the writer makes that call.
bool replaces_zlib_compress();

}  // namespace multum
