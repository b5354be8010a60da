// SPDX-License-Identifier: Apache-2.0
// Replaces the deflate that OpenEXR calls by quicker libraries: see the .cpp.
#pragma once

namespace multum {

/// True. Programs that call it have the replacement linked in; the writer does.
bool replaces_zlib_compress();

}  // namespace multum
