// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/source_lobes.h"

#include <fmt/format.h>

#include <filesystem>

#include "host/bakes/bake/bake_file.h"
#include "host/delivery/export/lobes/lobe_export.h"

namespace multum {
namespace {

constexpr int kLobeZstdLevel = 12;  // as UASTC's

}  // namespace

std::string bake_source_lobes(Device& device, const GltfAsset& asset, const PreparedSource& prepared,
                              std::size_t number, const SourceFitSettings& settings, Progress* progress) {
  const LobeSource& source = prepared.source;
  return of_image(asset, source.normal_image, prepared.normal_file, [&] {
    Progress cancelling = cancel_only(progress);
    BakeJob bake;
    bake.input = prepared.normal_file;
    bake.output = fmt::format("{}/lobes_{}.ndf.exr", settings.folder, number);
    bake.reading = gltf_normal_reading(source, settings);
    bake.fitting.first_level = 1;  // level 0 is the normal texture's
    bake.surface = settings.surface;
    bake.measure = false;
    bake.memory_bytes = resident_memory_of(settings.memory_bytes);
    bake.scratch_folder = settings.folder;
    bake.threads = settings.threads;
    bake_file(bake, nullptr, device, &cancelling);
    return bake.output;
  });
}

EncodedTexture encode_source_lobes(Device& device, const std::string& baked, const SourceFitSettings& settings,
                                   Progress* progress) {
  Progress cancelling = cancel_only(progress);
  LobeExportJob lobes;
  lobes.input = baked;
  lobes.output = baked + ".ktx2";
  lobes.zstd_level = kLobeZstdLevel;
  lobes.threads = settings.threads;
  export_lobes(lobes, device, &cancelling);
  return {lobes.output, "image/ktx2", std::filesystem::file_size(lobes.output)};
}

}  // namespace multum
