// SPDX-License-Identifier: Apache-2.0
// multum export: a normal map as materials of one lobe a texel, which engines load as they are.
#include <cstdio>
#include <memory>

#include "host/base/error.h"
#include "host/base/processes/machine.h"
#include "host/base/shown_text.h"
#include "host/export/baked_lobes.h"
#include "host/export/export_job.h"
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
  job.lobes = values.text("lobes").value_or("");
  job.measure = !values.flag("no_measure");
  job.accuracy.finds_optimum = values.flag("optimum");
  job.accuracy.cells_per_level = values.integer("cells").value_or(job.accuracy.cells_per_level);
  job.report = values.text("report").value_or("");
  job.scratch_folder = values.text("scratch").value_or("");
}

// A baked file has its normals as they are; how a map is to be read says nothing of them.
void check_no_reading_is_given(const std::string& input, const ParameterValues& values) {
  for (const Parameter& row : export_parameters().rows())
    if (row.group == kSourceGroup && values.has(row.name))
      throw Error(ErrorCode::kUsage,
                  input + ": is a baked file, whose normals are decoded; expected no " + row.option());
}

int run_export(ExportOptions& o) {
  o.job.threads = apply(o.common);
  keep_freed_memory();
  if (is_baked_name(o.job.input)) check_no_reading_is_given(o.job.input, o.values);
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
  command
      ->add_option("input", o.job.input,
                   bake_parameters().at("input").help + "; or a baked file, NAME.ndf.exr, whose level 0 is its map")
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
      "  multum export bricks_n.png -o bricks.dds --roughness bricks_orm.png --metalness bricks_orm.png");
  command->callback([options, exit_code] { *exit_code = run_export(*options); });
}

}  // namespace multum
