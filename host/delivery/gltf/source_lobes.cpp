// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/source_lobes.h"

#include <fmt/format.h>

#include <filesystem>

#include "host/bakes/bake/bake_file.h"
#include "host/delivery/export/lobes/lobe_colours.h"
#include "host/delivery/export/lobes/lobe_export.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/asset/textures/lobe_texture.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr int kLobeZstdLevel = 12;  // the same level as for UASTC

// Returns the error of the worst level.
double worst_error(const MovmfMipmap& exact, const MovmfMipmap& stored, const LobeSurface& surface) {
  const auto levels_of = [&](const MovmfMipmap& mipmap) {
    std::vector<LobeLevel> levels;
    for (std::size_t l = size_of(stored.header.first_level); l < mipmap.levels.size(); ++l)
      levels.push_back({mipmap.levels[l].width, mipmap.levels[l].height, &mipmap.levels[l].lobes});
    return levels;
  };
  return lobe_storage_error(levels_of(exact), levels_of(stored), surface).error;
}

// Prevents the bake from reporting an image under its name in the work folder if it has already been reported.
class QuietBake {
 public:
  QuietBake() : level_(log_level()) { set_log_level(LogLevel::kQuiet); }
  ~QuietBake() { set_log_level(level_); }
  QuietBake(const QuietBake&) = delete;
  QuietBake& operator=(const QuietBake&) = delete;

 private:
  const LogLevel level_;
};

}  // namespace

std::string bake_source_lobes(Device& device, const GltfAsset& asset, const PreparedSource& prepared,
                              std::size_t number, const SourceFitSettings& settings, Progress* progress) {
  const LobeSource& source = prepared.source;
  return of_image(asset, source.normal_image, prepared.normal_file, [&] {
    Progress cancelling = cancel_only(progress);
    const QuietBake quiet;
    BakeJob bake;
    bake.input = prepared.normal_file;
    bake.output = fmt::format("{}/lobes_{}.ndf.exr", settings.folder, number);
    bake.reading = gltf_normal_reading(source, settings);
    bake.fitting.first_level = 1;  // level 0 is in the normal texture
    bake.surface = settings.surface;
    bake.measure = false;
    bake.memory_bytes = resident_memory_of(settings.memory_bytes);
    bake.scratch_folder = settings.folder;
    bake.threads = settings.threads;
    if (prepared.colour_file.empty()) {
      bake_file(bake, nullptr, device, &cancelling);
      return bake.output;
    }
    try {
      bake.albedo = prepared.colour_file;
      bake_file(bake, nullptr, device, &cancelling);
    } catch (const Error& error) {
      // Lobes are made even if the colour image cannot be read.
      if (error.code() != ErrorCode::kInput) throw;
      bake.albedo.clear();
      bake_file(bake, nullptr, device, &cancelling);
    }
    return bake.output;
  });
}

std::optional<EncodedTexture> encode_source_colours(Device& device, const std::string& baked,
                                                    const SourceFitSettings& settings, Progress* progress) {
  if (!read_baked_header(baked).has_colours) return std::nullopt;
  Progress cancelling = cancel_only(progress);
  const LobeColourJob job{baked, baked + ".colours.ktx2", kLobeZstdLevel, settings.threads};
  const std::uint64_t bytes = export_lobe_colours(job, device, &cancelling);
  if (bytes == 0) return std::nullopt;
  return EncodedTexture{job.output, "image/ktx2", bytes, "bc"};
}

EncodedTexture encode_source_lobes(Device& device, const std::string& baked, const SourceLobeSettings& how,
                                   const SourceFitSettings& settings, Progress* progress) {
  Progress cancelling = cancel_only(progress);
  const MovmfMipmap exact = read_movmf_mipmap(baked, settings.threads);
  const auto encoded = [&](LobeTexels texels) {
    LobeExportJob lobes;
    lobes.input = baked;
    lobes.output = baked + ".ktx2";
    lobes.texels = texels;
    lobes.zstd_level = kLobeZstdLevel;
    lobes.keeps_colours = true;
    lobes.threads = settings.threads;
    export_lobes(lobes, device, &cancelling);
    EncodedTexture made{lobes.output, "image/ktx2", std::filesystem::file_size(lobes.output),
                        choice_name(kLobeTexels, texels)};
    made.storage_error = worst_error(exact, unpacked_mipmap(read_lobe_texture(lobes.output)), how.surface);
    return made;
  };
  EncodedTexture made = encoded(how.texels.value_or(LobeTexels::kBlocks));
  if (!how.texels && made.storage_error >= kStorageErrorMax) {
    const double refused = made.storage_error;
    made = encoded(LobeTexels::kRgba8);
    made.refused_error = refused;
    made.refused_format = choice_name(kLobeTexels, LobeTexels::kBlocks);
  }
  std::error_code ignored;
  std::filesystem::remove(baked, ignored);
  return made;
}

}  // namespace multum
