// SPDX-License-Identifier: Apache-2.0
// Bakes the lobes of a LobeSource's normal map, and encodes them as a texture for GPUs
// (docs/reference/lobe_textures.md, "Lobes for GPUs"), which a file carries in the extension MULTUM_lobes
// (docs/reference/gltf.md).
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "host/delivery/gltf/source_fit.h"
#include "host/delivery/gltf/texture_encoding.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct SourceLobeSettings {
  std::optional<LobeTexels> texels;  // unset: blocks, or RGBA8 where blocks add kStorageErrorMax or more
  LobeSurface surface;               // under the lobes, for the error that storing them adds
};

/// Bakes a file of the map's own size, whatever the fitted textures have, and returns its path. Files are named by
/// `number`. Cancels by `progress`, and counts nothing. Throws Error(kInput) naming the image, kEnvironment, Cancelled.
std::string bake_source_lobes(Device& device, const GltfAsset& asset, const PreparedSource& prepared,
                              std::size_t number, const SourceFitSettings& settings, Progress* progress);
/// Colours of its lobes (host/delivery/export/lobes/lobe_colours.h); none where the file has none. Throws
/// Error(kEnvironment), Cancelled.
std::optional<EncodedTexture> encode_source_colours(Device& device, const std::string& baked,
                                                    const SourceFitSettings& settings, Progress* progress);
/// Of such a file, which it removes. Throws Error(kEnvironment), Cancelled.
EncodedTexture encode_source_lobes(Device& device, const std::string& baked, const SourceLobeSettings& how,
                                   const SourceFitSettings& settings, Progress* progress);

}  // namespace multum
