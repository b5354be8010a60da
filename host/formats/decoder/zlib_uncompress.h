// SPDX-License-Identifier: Apache-2.0
// Replaces the inflate that OpenEXR calls by a quicker library: see the .cpp.
#pragma once

namespace multum {

/// True. Programs that call it have the replacement linked in; what opens images does.
bool replaces_zlib_uncompress();

}  // namespace multum
