// SPDX-License-Identifier: Apache-2.0
// Rewrites a glTF file as one GLB, which contains all referenced bytes and the new contents of buffer views. Offsets
// change by multiples of 16, so that aligned data stays aligned.
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
  std::string file;  // file with the bytes, if not empty
  std::uint64_t byte_count = 0;
};

/// New contents by the index of their buffer view in the rewritten JSON.
using ViewContents = std::map<std::size_t, ViewContent>;

/// Writes `json`, the rewritten asset.json, with its buffers. The file appears complete or not at all. Buffer views
/// with new contents need only exist in the array of `json`. Returns the size of the file in bytes. Throws
/// Error(kInput) if the data exceeds the limit of GLB, Error(kEnvironment), and Cancelled.
std::uint64_t write_glb(const GltfAsset& asset, GltfJson json, const ViewContents& contents, const std::string& output,
                        Progress* progress);

}  // namespace multum
