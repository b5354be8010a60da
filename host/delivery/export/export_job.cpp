// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/export_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/delivery/export/engines/engine_support.h"
#include "host/delivery/export/engines/texture_names.h"
#include "host/delivery/export/export_key.h"
#include "host/delivery/export/export_source.h"
#include "host/delivery/export/fit_journal.h"
#include "host/formats/asset/baked_file.h"
#include "host/formats/opencl/device_counts.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/stopwatch.h"
#include "host/foundation/parameters/engine_presets.h"

namespace multum {
namespace {

MaterialFolderSettings output_of(const ExportJob& job) {
  const ExportPlace name = export_place(job.output);
  if (name.format && job.format && *name.format != *job.format)
    throw Error(ErrorCode::kUsage,
                job.output + ": --format and the output name select different file types; expected the same type");
  MaterialFolderSettings settings;
  settings.folder = name.folder;
  settings.names = job.names;
  settings.material = name.stem;
  if (name.stem.empty() && job.names != TextureNames::kPlain) settings.material = material_of_file(job.input);
  settings.format = format_of(job);
  settings.texels = stored_texels(job);
  if (!can_store(settings.format, settings.texels))
    throw Error(
        ErrorCode::kUsage,
        "--texels: PNG files always have 8 bits per channel, EXR files always have half floats, and DDS files cannot "
        "store UASTC; expected --format ktx2 or --format dds for other texels, and --format ktx2 for uastc");
  const bool is_ktx2 = settings.format == MaterialFormat::kKtx2;
  if (job.zstd_level.value_or(0) > 0 && !is_ktx2)
    throw Error(ErrorCode::kUsage, "--zstd: only KTX2 files support this compression; add --format ktx2");
  settings.zstd_level = job.zstd_level.value_or(job.engine && is_ktx2 ? preset_of(*job.engine).zstd_level : 0);
  settings.has_anisotropy = job.lobe.is_anisotropic;
  settings.packing = job.packing;
  settings.has_occlusion = !job.occlusion.empty();
  settings.has_metalness = !job.metalness.empty();
  settings.green_is_down = job.write_green == GreenAxis::kDown;
  return settings;
}

void check_export_job(const ExportJob& job) {
  validate(job.lobe);
  if (job.lobe.is_anisotropic && job.form.value_or(MaterialForm::kOneLobe) != MaterialForm::kOneLobe)
    throw Error(
        ErrorCode::kUsage,
        fmt::format(
            "--form: found {}, expected one-lobe with --anisotropy, because other forms do not store a direction",
            choice_name(kMaterialForms, *job.form)));
  check_paths_differ(input_files(job), {job.report});
  if (!job.report.empty()) check_writable(job.report);
  std::error_code error;
  if (!job.scratch_folder.empty() && !std::filesystem::is_directory(job.scratch_folder, error))
    throw Error(ErrorCode::kEnvironment,
                job.scratch_folder + ": is not a folder; expected an existing folder for scratch files");
}

// Makes a folder in `folder` for files that this program exchanges with the UASTC encoder. Returns null if the job does
// not use UASTC. If the encoder is missing, throws an error before any input is read.
std::unique_ptr<WorkFolder> make_uastc_folder(const ExportJob& job, const std::string& folder,
                                              MaterialFolderSettings& output) {
  if (output.texels != MaterialTexels::kUastc) return nullptr;
  std::unique_ptr<WorkFolder> made = WorkFolder::make(job.scratch_folder.empty() ? folder : job.scratch_folder);
  output.uastc = {"--texels", made->path(), job.encoder, job.uastc_effort, job.threads};
  check_uastc_encoder(output.uastc);
  return made;
}

// Returns null if the job is not resumable or if another process is exporting to the same place.
std::unique_ptr<FitJournal> open_journal(const ExportJob& job, const ExportSource& source) {
  const ExportPlace place = export_place(job.output);
  const std::string name = place.folder + "/" + (place.stem.empty() ? "export" : place.stem);
  if (job.resume) {
    nlohmann::json key = fit_key(job, [&](const std::string& file) { return source.hashes->hash(file); });
    if (!source.map.report.tiles.empty()) key["tiles"] = source.map.report.tiles;
    return FitJournal::open(name, json_text(key));
  }
  WorkFolder::drop(partial_folder_of(name));
  return nullptr;
}

void make_files(const ExportJob& job, const ExportSource& source, const MaterialFolderSettings& output,
                FitJournal* journal, Device& device, ExportReport& report, Progress* progress) {
  Stopwatch stopwatch;
  std::optional<ExportMeter> meter;
  ExportAccuracySettings accuracy = job.accuracy;
  accuracy.texels = output.texels;
  if (job.measure) meter.emplace(report.width, report.height, accuracy, source.lobes.get());
  const std::unique_ptr<MaterialWriter> writer =
      make_material_folder(output, report.width, report.height, device, meter ? &*meter : nullptr);
  OneLobeInputs inputs = source.inputs(job);
  inputs.journal = journal;
  FormedReport formed =
      fit_formed_material(device, inputs, job.lobe, form_settings(job, output.folder), *writer, progress);
  report.plan = std::move(formed.fit.plan);
  report.form = std::move(formed.form);
  if (journal != nullptr) report.rows_resumed = journal->rows_resumed();
  report.seconds.emplace_back("fit", stopwatch.lap());
  if (output.texels == MaterialTexels::kUastc) {
    progress_stage(progress, "encode");
    writer->encode(progress);
    report.seconds.emplace_back("encode", stopwatch.lap());
  }
  if (meter) {
    report.accuracy = meter->run(inputs, job.lobe, progress);
    report.seconds.emplace_back("measure", stopwatch.lap());
  }
  progress_stage(progress, "write");
  writer->commit();
  report.seconds.emplace_back("write", stopwatch.lap());
}

// Returns the settings of an export for an engine, and where to read on.
std::string preset_line(const ExportJob& job, const MaterialFolderSettings& output) {
  if (!job.engine) return "";
  const EnginePreset& preset = preset_of(*job.engine);
  std::string line = fmt::format("for {}: green {}, {}", preset.title, output.green_is_down ? "down" : "up",
                                 packing_text(output.packing));
  if (job.occlusion.empty()) line += ", no occlusion";
  if (job.metalness.empty()) line += ", no metalness";
  line += fmt::format(", {}, {}", choice_name(kMaterialFormats, output.format),
                      choice_name(kMaterialTexels, output.texels));
  if (*preset.note != '\0') line += fmt::format("; {}", preset.note);
  return line + fmt::format("; import steps: docs/how-to/{}.md", preset.page);
}

std::vector<std::string> texts_of(const std::vector<std::string>& paths) {
  std::vector<std::string> texts;
  for (const std::string& path : paths) texts.push_back(text_of_path(path));
  return texts;
}

}  // namespace

MaterialFormat format_of(const ExportJob& job) {
  if (const auto named = export_place(job.output).format) return *named;
  if (job.format) return *job.format;
  return job.engine ? preset_of(*job.engine).format : MaterialFormat::kPng;
}

MaterialTexels stored_texels(const ExportJob& job) {
  if (job.texels) return *job.texels;
  const MaterialFormat format = format_of(job);
  if (job.engine && can_store(format, preset_of(*job.engine).texels)) return preset_of(*job.engine).texels;
  return format == MaterialFormat::kExr ? MaterialTexels::kRgba16f : MaterialTexels::kRgba8;
}

FormSettings form_settings(const ExportJob& job, const std::string& scratch_folder) {
  const MaterialTexels texels = stored_texels(job);
  const bool has_two_channels = texels == MaterialTexels::kRg8 || texels == MaterialTexels::kBlocks;
  return {job.form.value_or(MaterialForm::kOneLobe),
          job.engine.value_or(Engine::kThree),
          has_two_channels,
          {job.scratch_folder.empty() ? scratch_folder : job.scratch_folder,
           static_cast<std::int64_t>(job.memory_bytes / 16)}};
}

ExportPlace export_place(const std::string& output) {
  const std::filesystem::path path(output);
  const std::string extension = path.extension().string();
  std::error_code error;
  for (const char* other : {".png", ".exr", ".glb", ".gltf"})
    if (extension == other)
      throw Error(ErrorCode::kUsage,
                  output +
                      ": is the name of a single file; expected a folder, NAME.ktx2 or NAME.dds, because a material "
                      "has several textures. Use --format to choose their file type");
  if ((extension != ".ktx2" && extension != ".dds") || std::filesystem::is_directory(path, error))
    return {output, "", std::nullopt};
  const std::string folder = path.parent_path().string();
  return {folder.empty() ? "." : folder, path.stem().string(),
          extension == ".dds" ? MaterialFormat::kDds : MaterialFormat::kKtx2};
}

std::string ExportReport::to_json(const ExportJob& job) const {
  nlohmann::ordered_json json = {{"width", width},
                                 {"height", height},
                                 {"levels", level_count},
                                 {"format", input.format},
                                 {"encoding", input.encoding},
                                 {"warnings", with_advice(input.warnings)},
                                 {"side_warnings", side_warnings},
                                 {"base_roughness", nullptr},
                                 {"anisotropy", job.lobe.is_anisotropic},
                                 {"fast", job.lobe.is_fast},
                                 {"surface", map_surface_name(job.surface)},
                                 {"form", choice_name(kMaterialForms, job.form.value_or(MaterialForm::kOneLobe))},
                                 {"green", choice_name(kGreenAxes, job.write_green)},
                                 {"rows_resumed", rows_resumed},
                                 {"device", device},
                                 {"files", texts_of(files)},
                                 {"not_loaded_by", engines_failing},
                                 {"launches", launches}};
  if (job.roughness.empty()) json["base_roughness"] = job.lobe.base_roughness;
  if (roughness) json["roughness"] = roughness->to_text();
  if (job.engine) json["for"] = choice_name(kEngines, *job.engine);
  if (form) json["forms"] = {form->to_json()};
  for (const auto& [stage, time] : seconds) json["seconds"][stage] = time;
  if (job.measure) json["accuracy"] = nlohmann::ordered_json::parse(accuracy.to_json());
  return json_text(json, 2) + "\n";
}

ExportReport export_file(const ExportJob& job, Device& device, Progress* progress) {
  check_export_job(job);
  MaterialFolderSettings output = output_of(job);
  const std::string place = existing_part(output.folder);
  check_writable(place + "/" + (output.material.empty() ? "export" : output.material + "_"));
  const std::unique_ptr<WorkFolder> uastc_folder = make_uastc_folder(job, place, output);
  Stopwatch stopwatch;
  ExportReport report;
  progress_stage(progress, "read");
  const ExportSource source = read_export_source(job, place, progress);
  report.input = source.map.report;
  if (source.material) report.roughness = source.material->roughness;
  report.width = source.map.normals.width();
  report.height = source.map.normals.height();
  report.level_count = mip_level_count(report.width, report.height);
  check_sides(job.sides, job.input, report.width, report.height);
  if (job.keeps_mosaic)
    report.mosaic = std::make_shared<const MapMosaic>(
        mosaic_of(source.map.normals, source.material ? &source.material->planes : nullptr, kSmallMosaic));
  report.textures = texture_list(output);
  report.preset_line = preset_line(job, output);
  report.files = material_files(output, report.width, report.height);
  report.engines_failing = engines_that_fail(output.format, output.texels);
  // With an engine, only this engine matters.
  const auto is_asked = [&](const std::string& name) { return name == preset_of(*job.engine).title; };
  if (!job.engine || std::any_of(report.engines_failing.begin(), report.engines_failing.end(), is_asked))
    report.engine_line = engine_line(output.format, output.texels, "--texels uastc");
  report.side_warnings = side_warnings(output, report.width, report.height);
  for (const std::string& warning : report.side_warnings) log_warning(job.input, warning);
  check_paths_differ(input_files(job), report.files);
  make_folder(output.folder);
  report.seconds.emplace_back("read", stopwatch.lap());

  progress_start(progress, static_cast<std::uint64_t>(report.width) * static_cast<std::uint64_t>(report.height));
  const DeviceCounts counts(device);
  report.device = device.info().name;
  const std::unique_ptr<FitJournal> journal = open_journal(job, source);
  try {
    make_files(job, source, output, journal.get(), device, report, progress);
  } catch (const Cancelled&) {
    if (journal != nullptr) journal->leave();
    throw;
  }
  report.launches = counts.launches();
  if (!job.report.empty()) write_text_file(job.report, report.to_json(job));
  progress_finish(progress);
  return report;
}

}  // namespace multum
