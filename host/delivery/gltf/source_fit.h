// SPDX-License-Identifier: Apache-2.0
// Fits the textures of one LobeSource. Reads its images, resizes them to one size, and fits a lobe to each texel of
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
  std::string folder;  // folder for images and levels
  bool is_fast = false;
  MapSurface surface = MapSurface::kTexels;
  std::optional<ZRange> z_range;  // z range of all normal maps; if not set, found by statistics
  bool two_channel = false;       // rebuild z of all normal maps
  int side_multiple = 1;          // texture sides are multiples of this number
  std::uint64_t memory_bytes = std::uint64_t{256} << 20;
  int threads = 1;
};

/// A source that is ready to be fitted, or the reason why it is not fitted.
struct PreparedSource {
  LobeSource source;
  std::string normal_file, surface_file;  // names of files in the folder
  std::string colour_file;                // image of the same size as the normals; empty if there is none
  int width = 0, height = 0;              // size of the textures
  std::string kept;                       // reason why the source is not fitted; empty if it is fitted
  bool is_bad = false;                    // true if the reason is a fault of an image
  bool is_plain = false;                  // true if the reason is that the material's own mips are as good
  std::vector<std::string> notes;
  // True if level 0 of the texture is the unchanged image of the file, in a format that every glTF loader supports.
  bool normal_is_original = false, surface_is_original = false;

  std::uint64_t texel_count() const { return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height); }
};

/// Runs `body`. In errors about the temporary `file`, replaces the file's name with the name of the image that was
/// written to it.
template <typename Body>
auto of_image(const GltfAsset& asset, std::size_t image, const std::string& file, const Body& body) {
  try {
    return body();
  } catch (...) {
    const Error error = caught_error(file);
    std::string message = error.what();
    const std::string name = fmt::format("{}: image {}", asset.path, image);
    const std::string shown = Error(error.code(), file).what();  // name of the file in messages
    if (const std::size_t at = message.find(shown); at != std::string::npos) message.replace(at, shown.size(), name);
    else message = name + ": " + message;
    throw Error(error.code(), message);
  }
}

/// Returns the settings for reading a glTF normal texture, including its blue channel. It is an error if the blue
/// channel is not z.
NormalMapSettings gltf_normal_reading(const LobeSource& source, const SourceFitSettings& settings);

/// Writes the images into the folder and checks their sizes. If an image cannot be read, its materials stay unchanged.
/// Throws Error(kEnvironment).
PreparedSource prepare_source(const GltfAsset& asset, const LobeSource& source, const SourceFitSettings& settings);

/// Adds the base colour, if it is readable and has the size of the normal map.
void add_colours(const GltfAsset& asset, std::size_t image, const SourceFitSettings& settings, PreparedSource& made);

/// Returns the fault of an image as the reason why its materials are kept, as in "image 2: found ...". Rethrows errors
/// other than kInput.
std::string why_kept(const GltfAsset& asset, const Error& error);

/// The normals and the material of a source.
struct SourcePlanes {
  PlaneStore normals;
  std::optional<PlaneStore> material;  // alpha^2, occlusion and metalness; set if the source has a surface image
};

/// Reads the images of a prepared source. Throws Error(kInput) that names the image, and Error(kEnvironment).
SourcePlanes read_source(const GltfAsset& asset, const PreparedSource& prepared, const SourceFitSettings& settings,
                         Progress* progress);

/// The fitted textures. A texture that does not exist is null.
struct FittedSource {
  std::unique_ptr<LevelFile> normal, surface, anisotropy;
  // The mips that a renderer makes from level 0. They hold normals, with roughness in alpha. The pointer is null if
  // `anisotropy` is set.
  std::unique_ptr<LevelFile> averages;
};

/// File names contain `number`. A surface texture that is 1 everywhere is not written. Progress: one unit per texel.
/// Throws Error(kInput) that names the image, Error(kEnvironment), and Cancelled.
FittedSource fit_source(Device& device, const GltfAsset& asset, const PreparedSource& prepared, std::size_t number,
                        const SourceFitSettings& settings, Progress* progress);

}  // namespace multum
