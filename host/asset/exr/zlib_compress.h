// SPDX-License-Identifier: Apache-2.0
// OpenEXR's deflate, by quicker libraries: see the .cpp.
#pragma once

namespace multum {

/// True. Programs that call it have the replacement linked in; the writer does.
bool replaces_zlib_compress();

}  // namespace multum
