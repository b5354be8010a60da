// SPDX-License-Identifier: Apache-2.0
// OpenEXR's deflate, by libdeflate: see the .cpp.
#pragma once

namespace multum {

/// True. Programs that call it have the replacement linked in; the writer does.
bool compresses_by_libdeflate();

}  // namespace multum
