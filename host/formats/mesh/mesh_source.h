// SPDX-License-Identifier: Apache-2.0
// Reads meshes in a child process, because assimp crashes on some files, or takes minutes and gigabytes.
#pragma once

#include "host/foundation/sandbox/decoding_child.h"

namespace multum {

/// Sets the child for the whole process. Without this call, the defaults of DecodingChild apply.
void set_mesh_child(DecodingChild child);

}  // namespace multum
