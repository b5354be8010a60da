// SPDX-License-Identifier: Apache-2.0
// Reads meshes in a child process, since assimp dies on some files or takes minutes and gigabytes.
#pragma once

#include "host/foundation/sandbox/decoding_child.h"

namespace multum {

/// For the whole process; DecodingChild's defaults unless a program says otherwise at its start.
void set_mesh_child(DecodingChild child);

}  // namespace multum
