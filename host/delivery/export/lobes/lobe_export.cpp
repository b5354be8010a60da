// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/lobes/lobe_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/delivery/export/lobes/lobe_encoding.h"
#include "host/delivery/export/texture_file.h"
#include "host/formats/asset/gpu_bytes.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

TexelFormat lobe_format(LobeTexels texels) {
  switch (texels) {
    case LobeTexels::kRgba16f: return TexelFormat::kRgba16f;
    case LobeTexels::kRgba8: return TexelFormat::kRgba8;
    case LobeTexels::kBlocks: return TexelFormat::kBc5;
  }
  MULTUM_CHECK(false);
}

// Reads the lobes to export. Omits level 0, which is the normal map.
MovmfMipmap read_lobes(const LobeExportJob& job) {
  const BakedHeader header = read_baked_header(job.input);
  const auto refuse = [&](const std::string& found, const char* expected) {
    refuse_file(job.input, fmt::format("found {}, expected {}", found, expected));
  };
  if (!representation_info(header.representation).has_kappa)
    refuse("no vMF lobes", "a file of multum bake without --ndf, because --lobes stores only vMF lobes");
  if (header.level_count() < 2) refuse("a map of one texel", "a map with more than one level");
  if (header.weight_count > 0)
    refuse("weights of basis BRDFs", "a file without weights, because the texture cannot store weights");
  if (header.has_colours && !job.keeps_colours)
    log_warning(job.input, "has colours, which --lobes does not store; renderers read the albedo map instead");
  return read_movmf_mipmap(job.input, job.threads);
}

LobeTextureHeader lobe_texture_header(const LobeExportJob& job, const MovmfMipmap& mipmap) {
  LobeTextureHeader header{full_header(mipmap), job.texels, {}};
  header.map.first_level = std::max(mipmap.header.first_level, 1);
  header.map.has_colours = false;
  return header;
}

std::uint64_t stored_texels(const MovmfMipmap& mipmap, int first_level) {
  std::uint64_t count = 0;
  for (std::size_t l = size_of(first_level); l < mipmap.levels.size(); ++l)
    count += size_of(mipmap.levels[l].width) * size_of(mipmap.levels[l].height);
  return count;
}

}  // namespace

std::string LobeExportReport::to_json() const {
  nlohmann::ordered_json json = {{"width", header.map.width},
                                 {"height", header.map.height},
                                 {"first_level", header.map.first_level},
                                 {"levels", header.level_count()},
                                 {"lobes", header.lobes.size()},
                                 {"texels", choice_name(kLobeTexels, header.texels)},
                                 {"layers", header.layer_count()},
                                 {"gpu_bytes", gpu_bytes},
                                 {"bc5_bc4_bytes", default_bytes},
                                 {"bytes_ratio", bytes_ratio()},
                                 {"device", device}};
  for (const auto& [stage, time] : seconds) json["seconds"][stage] = time;
  return json_text(json, 2) + "\n";
}

LobeExportReport export_lobes(const LobeExportJob& job, Device& device, Progress* progress) {
  check_paths_differ({job.input}, {job.output, job.report});
  for (const std::string& file : {job.output, job.report})
    if (!file.empty()) check_writable(file);
  Stopwatch stopwatch;
  LobeExportReport report;
  progress_stage(progress, "read");
  const MovmfMipmap mipmap = read_lobes(job);
  report.header = lobe_texture_header(job, mipmap);
  const BakedHeader& map = report.header.map;
  report.seconds.emplace_back("read", stopwatch.lap());

  const auto lobe_count = size_of(mipmap.lobe_count());
  progress_start(progress, lobe_count * stored_texels(mipmap, map.first_level));
  progress_stage(progress, "encode");
  LobeEncoder encoder(job.texels, device);
  std::vector<LobeBasis> bases;
  for (std::size_t j = 0; j < lobe_count; ++j) {
    bases.push_back(fit_lobe_basis(mipmap, map.first_level, static_cast<int>(j)));
    report.header.lobes.push_back(encoder.unpacking(bases[j]));
  }
  const LeveledTexture texture{lobe_format(job.texels), mip_level_size(map.width, map.first_level),
                               mip_level_size(map.height, map.first_level), report.header.level_count(),
                               report.header.layer_count()};
  const std::unique_ptr<TextureFile> file =
      make_ktx2_file(job.output, texture, {"", job.zstd_level, {{kLobeTextureKey, lobe_texture_text(report.header)}}});
  for (int l = 0; l < texture.level_count; ++l) {
    const MovmfLevel& level = mipmap.levels[size_of(map.first_level + l)];
    const std::vector<std::uint8_t> layers = encoder.encode(bases, level.width, level.height, level.lobes, progress);
    file->write_rows(l, block_rows(texture, l), layers.data());
  }
  progress_stage(progress, "write");
  file->finish();
  report.seconds.emplace_back("encode", stopwatch.lap());
  report.device = device.info().name;
  report.gpu_bytes = lobe_texture_bytes(report.header);
  report.default_bytes = default_gpu_bytes(map.width, map.height);
  if (!job.report.empty()) write_text_file(job.report, report.to_json());
  progress_finish(progress);
  return report;
}

}  // namespace multum
