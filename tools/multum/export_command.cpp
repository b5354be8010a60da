// SPDX-License-Identifier: Apache-2.0
// multum export: a normal map as materials of one lobe a texel, which engines load as they are.
#include <cstdio>
#include <memory>

#include "host/base/processes/machine.h"
#include "host/base/shown_text.h"
#include "host/export/export_job.h"
#include "host/export/lobes/lobe_export.h"
#include "host/image/normals/reading_parameters.h"
#include "host/parameters/bake_parameters.h"
#include "host/parameters/export_parameters.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/commands.h"

namespace multum {
namespace {

struct ExportOptions {
  CommonOptions common;
  ExportJob job;
  ParameterValues values{export_parameters()};
};

const Choices<MaterialFormat> kMaterialFormats = {{"png", MaterialFormat::kPng},
                                                  {"exr", MaterialFormat::kExr},
                                                  {"ktx2", MaterialFormat::kKtx2},
                                                  {"dds", MaterialFormat::kDds}};
const Choices<MaterialTexels> kMaterialTexels = {{"rgba8", MaterialTexels::kRgba8},
                                                 {"rgba16f", MaterialTexels::kRgba16f},
                                                 {"rg8", MaterialTexels::kRg8},
                                                 {"bc", MaterialTexels::kBlocks}};

const Choices<LobeTexels> kLobeTexels = {
    {"rgba8", LobeTexels::kRgba8}, {"rgba16f", LobeTexels::kRgba16f}, {"bc", LobeTexels::kBlocks}};

void apply_to_export(const ParameterValues& values, ExportJob& job) {
  apply_reading(values, job.reading);
  job.lobe.base_roughness = values.number("base_roughness").value_or(job.lobe.base_roughness);
  job.lobe.is_anisotropic = values.flag("anisotropy");
  job.lobe.is_fast = values.flag("fast");
  job.roughness = values.text("roughness").value_or("");
  if (const auto gloss = values.text("gloss")) job.roughness = *gloss, job.roughness_is_gloss = true;
  job.occlusion = values.text("occlusion").value_or("");
  job.metalness = values.text("metalness").value_or("");
  job.format = values.choice("format", kMaterialFormats);
  job.texels = values.choice("texels", kMaterialTexels);
  job.zstd_level = values.integer("zstd").value_or(job.zstd_level);
  job.has_roughness_alone = values.flag("roughness_alone");
  if (const auto bytes = values.bytes("memory")) job.memory_bytes = static_cast<std::uint64_t>(*bytes);
  job.measure = !values.flag("no_measure");
  job.accuracy.finds_optimum = values.flag("optimum");
  job.accuracy.cells_per_level = values.integer("cells").value_or(job.accuracy.cells_per_level);
  job.report = values.text("report").value_or("");
  job.scratch_folder = values.text("scratch").value_or("");
}

// The source options read maps: of a baked file there is nothing to say.
LobeExportJob lobe_export_job(const ExportOptions& o) {
  for (const Parameter& row : export_parameters().rows())
    if (row.group == kSourceGroup && o.values.has(row.name))
      throw Error(ErrorCode::kUsage,
                  "--lobes: found --" + row.name + ", expected it for a map: a baked file is read as it is");
  LobeExportJob job{o.job.input, o.job.output, o.values.text("report").value_or("")};
  if (!o.job.output.ends_with(".ktx2"))
    throw Error(ErrorCode::kUsage, o.job.output + ": is no name of a KTX2 file, expected NAME.ktx2 with --lobes");
  if (const auto name = o.values.text("texels")) {
    const std::optional<LobeTexels> texels = find_choice(kLobeTexels, *name);
    if (!texels)
      throw Error(ErrorCode::kUsage, "--texels: found " + *name + ", expected bc, rgba8 or rgba16f with --lobes");
    job.texels = *texels;
  }
  job.zstd_level = o.values.integer("zstd").value_or(0);
  return job;
}

int run_lobe_export(ExportOptions& o) {
  LobeExportJob job = lobe_export_job(o);
  job.threads = apply(o.common);
  Device device = Device::when_needed({o.values.text("device").value_or("")});
  const auto progress = make_progress(o.common);
  const LobeExportReport report = export_lobes(job, device, progress.get());
  if (o.common.quiet) return 0;
  print_shown(stdout,
              "%s: written: %zu lobes, %d layers, levels from %d on, %.1f MB on the GPU, %.2f times BC5 and BC4\n",
              job.output.c_str(), report.header.lobes.size(), report.header.layer_count(),
              report.header.map.first_level, static_cast<double>(report.gpu_bytes) / 1e6, report.bytes_ratio());
  for (const auto& [stage, seconds] : report.seconds)
    if (o.common.verbose) print_shown(stdout, "%s %.2f s\n", stage.c_str(), seconds);
  return 0;
}

int run_export(ExportOptions& o) {
  if (o.values.flag("lobes")) return run_lobe_export(o);
  o.job.threads = apply(o.common);
  keep_freed_memory();
  apply_to_export(o.values, o.job);
  Device device = Device::when_needed({o.values.text("device").value_or("")});
  const auto progress = make_progress(o.common);
  const ExportReport report = export_file(o.job, device, progress.get());
  if (o.common.quiet) return 0;
  print_shown(stdout, "%s: %d levels of %d x %d, %zu files: %s\n", o.job.output.c_str(), report.level_count,
              report.width, report.height, report.files.size(), report.textures.c_str());
  print_shown(stdout, "%s", report.accuracy.to_text().c_str());
  if (!o.common.verbose) return 0;
  print_shown(stdout, "%s", report.plan.c_str());
  for (const auto& [stage, seconds] : report.seconds) print_shown(stdout, "%s %.2f s\n", stage.c_str(), seconds);
  return 0;
}

}  // namespace

void add_export_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<ExportOptions>();
  ExportOptions& o = *options;
  CLI::App* command = app.add_subcommand(
      "export",
      "fit a normal map's mips as materials that engines load: normal, roughness, anisotropy (docs/EXPORT.md)");
  command->add_option("input", o.job.input, bake_parameters().at("input").help + "; with --lobes a baked file")
      ->required();
  command
      ->add_option("-o,--output", o.job.output,
                   "folder to write to: an image a texture and level, or a KTX2 or DDS file a texture; or NAME.ktx2, "
                   "NAME.dds: NAME_normal.ktx2, NAME_orm.ktx2 and, with --anisotropy, NAME_anisotropy.ktx2")
      ->required();
  add_parameter_options(*command, o.values);
  add_common_options(*command, o.common);
  add_decoding_option(*command);
  command->footer(
      "Examples:\n"
      "  multum export bricks_n.png -o bricks/                      # normal_00.png, orm_00.png and so on\n"
      "  multum export bricks_n.png -o bricks.ktx2 --zstd 15        # bricks_normal.ktx2, bricks_orm.ktx2, all levels\n"
      "  multum export bricks.ndf.exr --lobes -o bricks.ktx2        # lobes for GPUs, of multum bake (docs/FORMAT.md)\n"
      "  multum export bricks_n.png -o bricks.dds --roughness bricks_orm.png --metalness bricks_orm.png");
  command->callback([options, exit_code] { *exit_code = run_export(*options); });
}

}  // namespace multum
