// SPDX-License-Identifier: Apache-2.0
// Lays out the bytes of a glTF file anew as one GLB: what it had, without the bytes that nobody refers to any more, and
// new contents of buffer views. Offsets move by multiples of 16, so whatever was aligned still is.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "host/delivery/gltf/gltf_asset.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// New bytes of a buffer view.
struct ViewContent {
  std::string bytes;
  std::string file;  // which has them, where it is not empty
  std::uint64_t byte_count = 0;
};

/// By index of the view in the rewritten JSON.
using ViewContents = std::map<std::size_t, ViewContent>;

/// Writes `json`, which is asset.json rewritten, with its buffers: a file that appears whole or not at all. Buffer
/// views with new contents need no more than their place in the array. Returns the file's bytes. Throws Error(kInput)
/// for more than GLB holds, Error(kEnvironment), Cancelled.
std::uint64_t write_glb(const GltfAsset& asset, GltfJson json, const ViewContents& contents, const std::string& output,
                        Progress* progress);

}  // namespace multum
