// SPDX-License-Identifier: Apache-2.0
// Fits the textures of one LobeSource: reads its images, brings them to one size, and fits a lobe to each texel of
// every level (host/delivery/export/one_lobe_fit.h).
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/delivery/export/one_lobe_fit.h"
#include "host/delivery/export/uastc/level_file.h"
#include "host/delivery/gltf/material_plan.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/surface_points.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/base/system_failure.h"

namespace multum {

struct SourceFitSettings {
  std::string folder;  // for images and levels
  bool is_fast = false;
  MapSurface surface = MapSurface::kTexels;
  std::optional<ZRange> z_range;  // of all normal maps; unset: from statistics
  bool two_channel = false;       // rebuild z of all normal maps
  int side_multiple = 1;          // sides of textures are multiples of it
  std::uint64_t memory_bytes = std::uint64_t{256} << 20;
  int threads = 1;
};

/// What a source's fit will be.
struct PreparedSource {
  LobeSource source;
  std::string normal_file, surface_file;  // in the folder
  std::string colour_file;                // of the normals' size; empty: none
  int width = 0, height = 0;              // of the textures
  std::string kept;                       // why it is not fitted; empty: it is
  bool is_bad = false;                    // that reason is a fault of an image
  bool is_plain = false;                  // that reason is that its own mips are as near
  std::vector<std::string> notes;
  // Level 0 of the texture is the image as it is in the file, of a kind that glTF has everywhere.
  bool normal_is_original = false, surface_is_original = false;

  std::uint64_t texel_count() const { return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height); }
};

/// Runs `body`; what it says of `file`, which an image was written to, is said of the image.
template <typename Body>
auto of_image(const GltfAsset& asset, std::size_t image, const std::string& file, const Body& body) {
  try {
    return body();
  } catch (...) {
    const Error error = caught_error(file);
    std::string message = error.what();
    const std::string name = fmt::format("{}: image {}", asset.path, image);
    const std::string shown = Error(error.code(), file).what();  // as messages name it
    if (const std::size_t at = message.find(shown); at != std::string::npos) message.replace(at, shown.size(), name);
    else message = name + ": " + message;
    throw Error(error.code(), message);
  }
}

/// All that glTF says of a normal texture, and what the settings say of blue. A blue that is no z is refused.
NormalMapSettings gltf_normal_reading(const LobeSource& source, const SourceFitSettings& settings);

/// Writes the images into the folder and looks at their sizes; an image that cannot be read is a reason to keep the
/// material. Throws Error(kEnvironment).
PreparedSource prepare_source(const GltfAsset& asset, const LobeSource& source, const SourceFitSettings& settings);

/// Gives it the base colour, if that can be read and has the size of the normal map.
void add_colours(const GltfAsset& asset, std::size_t image, const SourceFitSettings& settings, PreparedSource& made);

/// What is wrong with an image as a reason to keep the material that has it: "image 2: found ...". Throws an error that
/// is not kInput again.
std::string why_kept(const GltfAsset& asset, const Error& error);

/// Textures by what they hold; null: there is none.
struct FittedSource {
  std::unique_ptr<LevelFile> normal, surface, anisotropy;
  // What a renderer's own mips of level 0 are: normals, alpha roughness. None where `anisotropy` is.
  std::unique_ptr<LevelFile> averages;
};

/// Files are named by `number`. A surface that is 1 everywhere is none. Progress: a unit a texel. Throws
/// Error(kInput) naming the image, kEnvironment, Cancelled.
FittedSource fit_source(Device& device, const GltfAsset& asset, const PreparedSource& prepared, std::size_t number,
                        const SourceFitSettings& settings, Progress* progress);

}  // namespace multum
