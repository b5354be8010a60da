// SPDX-License-Identifier: Apache-2.0
// Bakes the lobes of a LobeSource's normal map, and encodes them as a texture for GPUs
// (docs/reference/lobe_textures.md, "Lobes for GPUs"). Model files store this texture in the extension MULTUM_lobes
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
  std::optional<LobeTexels> texels;  // if not set, blocks, or RGBA8 if blocks raise the error by kStorageErrorMax or
                                     // more
  LobeSurface surface;               // properties of the surface, for the storage error
};

/// Bakes a file of the map's own size, even if the fitted textures have another size, and returns its path. File names
/// contain `number`. The progress callback can cancel, but no progress units are advanced. Throws Error(kInput) that
/// names the image, Error(kEnvironment), and Cancelled.
std::string bake_source_lobes(Device& device, const GltfAsset& asset, const PreparedSource& prepared,
                              std::size_t number, const SourceFitSettings& settings, Progress* progress);
/// Encodes the colours of the lobes (host/delivery/export/lobes/lobe_colours.h). Returns nullopt if the file has no
/// colours. Throws Error(kEnvironment) and Cancelled.
std::optional<EncodedTexture> encode_source_colours(Device& device, const std::string& baked,
                                                    const SourceFitSettings& settings, Progress* progress);
/// Encodes the lobes of a baked file and removes the file. Throws Error(kEnvironment) and Cancelled.
EncodedTexture encode_source_lobes(Device& device, const std::string& baked, const SourceLobeSettings& how,
                                   const SourceFitSettings& settings, Progress* progress);

}  // namespace multum
