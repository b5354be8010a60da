// SPDX-License-Identifier: Apache-2.0
#include "host/export/export_job.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/asset/baked_file.h"
#include "host/base/error.h"
#include "host/base/files/atomic_file.h"
#include "host/base/files/output_paths.h"
#include "host/base/log.h"
#include "host/base/stopwatch.h"
#include "host/export/baked_lobes.h"

namespace multum {
namespace {

ChannelFile channel_file(const std::string& text) { return text.empty() ? ChannelFile{} : parse_channel_file(text); }

LobeMaterialFiles material_files_of(const ExportJob& job) {
  LobeMaterialFiles files{channel_file(job.roughness), channel_file(job.occlusion), channel_file(job.metalness)};
  files.roughness.is_gloss = job.roughness_is_gloss;
  return files;
}

std::vector<std::string> export_inputs(const ExportJob& job) {
  std::vector<std::string> inputs = {job.input};
  const LobeMaterialFiles files = material_files_of(job);
  for (const ChannelFile& file : {files.roughness, files.occlusion, files.metalness})
    if (!file.path.empty()) inputs.push_back(file.path);
  if (!job.lobes.empty()) inputs.push_back(job.lobes);
  return inputs;
}

// The lobes that are measured beside the export. Of an input that has none of vMF, or starts at another level, there
// are none; a file that was named for it has to have them.
std::unique_ptr<BakedLobes> compared_lobes(const ExportJob& job, const NormalMapRows& map, InputHashes& hashes) {
  if (!job.measure || (job.lobes.empty() && !is_baked_name(job.input))) return nullptr;
  if (job.lobes.empty()) {
    if (read_baked_header(job.input).representation != Representation::kMovmf) return nullptr;
    return std::make_unique<BakedLobes>(job.input, job.accuracy.levels);
  }
  auto lobes = std::make_unique<BakedLobes>(job.lobes, job.accuracy.levels);
  const int width = map.normals.width(), height = map.normals.height();
  if (lobes->width() != width || lobes->height() != height)
    throw Error(ErrorCode::kInput, fmt::format("{}: was baked from a map of {} x {} texels, expected {} x {} as {} has",
                                               job.lobes, lobes->width(), lobes->height(), width, height, job.input));
  if (!is_baked_name(job.input) && lobes->source_hash() != hashes.hash(job.input))
    throw Error(ErrorCode::kInput,
                fmt::format("{}: was baked from another map than {}; expected a bake of it", job.lobes, job.input));
  return lobes;
}

// What `output` names: a folder, or files whose names begin alike.
struct OutputName {
  std::string folder, name_prefix;
  std::optional<MaterialFormat> format;
};

OutputName output_name(const std::string& output) {
  const std::filesystem::path path(output);
  const std::string extension = path.extension().string();
  std::error_code error;
  for (const char* other : {".png", ".exr", ".glb", ".gltf"})
    if (extension == other)
      throw Error(ErrorCode::kUsage,
                  output +
                      ": is a name of one file, expected a folder, NAME.ktx2 or NAME.dds: a material is several "
                      "textures; --format says of which kind");
  if ((extension != ".ktx2" && extension != ".dds") || std::filesystem::is_directory(path, error))
    return {output, "", std::nullopt};
  const std::string folder = path.parent_path().string();
  return {folder.empty() ? "." : folder, path.stem().string() + "_",
          extension == ".dds" ? MaterialFormat::kDds : MaterialFormat::kKtx2};
}

MaterialFolderSettings output_of(const ExportJob& job) {
  const OutputName name = output_name(job.output);
  if (name.format && job.format && *name.format != *job.format)
    throw Error(ErrorCode::kUsage, job.output + ": --format names another kind of file than the output's name does");
  MaterialFolderSettings settings;
  settings.folder = name.folder;
  settings.name_prefix = name.name_prefix;
  settings.format = name.format.value_or(job.format.value_or(MaterialFormat::kPng));
  settings.texels =
      job.texels.value_or(settings.format == MaterialFormat::kExr ? MaterialTexels::kRgba16f : MaterialTexels::kRgba8);
  if (!can_store(settings.format, settings.texels))
    throw Error(ErrorCode::kUsage,
                "--texels: PNG files are of 8 bits a channel and EXR files of half floats; expected a KTX2 or DDS "
                "file for any other (--format ktx2, --format dds)");
  if (job.zstd_level > 0 && settings.format != MaterialFormat::kKtx2)
    throw Error(ErrorCode::kUsage, "--zstd: only KTX2 files can be compressed so (--format ktx2)");
  settings.zstd_level = job.zstd_level;
  settings.has_anisotropy = job.lobe.is_anisotropic;
  settings.has_roughness_alone = job.has_roughness_alone;
  return settings;
}

void check_export_job(const ExportJob& job) {
  validate(job.lobe);
  check_paths_differ(export_inputs(job), {job.report});
  if (!job.report.empty()) check_writable(job.report);
  std::error_code error;
  if (!job.scratch_folder.empty() && !std::filesystem::is_directory(job.scratch_folder, error))
    throw Error(ErrorCode::kEnvironment, job.scratch_folder + ": is not a folder, expected a folder for scratch files");
}

// What an export reads.
struct ExportSource {
  NormalMapRows map;
  std::optional<LobeMaterial> material;
  std::unique_ptr<BakedLobes> lobes;  // null: none to compare with

  OneLobeInputs inputs(const ExportJob& job) const {
    OneLobeInputs inputs;
    inputs.normals = &map.normals;
    if (material) inputs.material = &material->planes;
    inputs.has_roughness = !job.roughness.empty();
    inputs.has_occlusion = !job.occlusion.empty();
    inputs.has_metalness = !job.metalness.empty();
    inputs.memory_bytes = job.memory_bytes / 2;
    inputs.threads = job.threads;
    return inputs;
  }
};

ExportSource read_export_source(const ExportJob& job, const std::string& folder, Progress* progress) {
  InputHashes hashes;
  for (const std::string& file : export_inputs(job)) hashes.note(file);
  const SpillPolicy spill = {job.scratch_folder.empty() ? folder : job.scratch_folder,
                             static_cast<std::int64_t>(job.memory_bytes / 4)};
  ExportSource source{is_baked_name(job.input)
                          ? read_baked_normals(job.input, spill, progress)
                          : read_normal_map_rows(job.input, job.reading, spill, job.threads, progress),
                      std::nullopt, nullptr};
  source.lobes = compared_lobes(job, source.map, hashes);
  if (!job.roughness.empty() || !job.occlusion.empty() || !job.metalness.empty())
    source.material = read_lobe_material(material_files_of(job), source.map.normals.width(),
                                         source.map.normals.height(), spill, job.threads);
  for (const std::string& file : export_inputs(job)) hashes.check_unchanged(file);
  const NormalMapReport& found = source.map.report;
  log_info(fmt::format("{}: {} x {}, {}; {}", job.input, source.map.normals.width(), source.map.normals.height(),
                       found.encoding, found.encoding_reason));
  for (const std::string& warning : found.warnings) log_warning(job.input + ": " + warning);
  if (source.material && source.material->roughness) {
    log_info(fmt::format("{}: {}", material_files_of(job).roughness.path, source.material->roughness->to_text()));
    for (const std::string& warning : source.material->roughness->warnings) log_warning(warning);
  }
  return source;
}

// Shows stored rows to the measurement.
class MeterSink : public MaterialSink {
 public:
  explicit MeterSink(ExportMeter& meter) : meter_(meter) {}
  void add_level(int level, int first_row, MaterialRows rows) override { meter_.add_rows(level, first_row, rows); }

 private:
  ExportMeter& meter_;
};

}  // namespace

std::string ExportReport::to_json(const ExportJob& job) const {
  nlohmann::ordered_json json = {{"width", width},
                                 {"height", height},
                                 {"levels", level_count},
                                 {"format", input.format},
                                 {"encoding", input.encoding},
                                 {"warnings", input.warnings},
                                 {"side_warnings", side_warnings},
                                 {"base_roughness", nullptr},
                                 {"anisotropy", job.lobe.is_anisotropic},
                                 {"fast", job.lobe.is_fast},
                                 {"device", device},
                                 {"files", files},
                                 {"launches", launches}};
  if (job.roughness.empty()) json["base_roughness"] = job.lobe.base_roughness;
  if (roughness) json["roughness"] = roughness->to_text();
  for (const auto& [stage, time] : seconds) json["seconds"][stage] = time;
  if (job.measure) json["accuracy"] = nlohmann::ordered_json::parse(accuracy.to_json());
  return json.dump(2) + "\n";
}

ExportReport export_file(const ExportJob& job, Device& device, Progress* progress) {
  check_export_job(job);
  const MaterialFolderSettings output = output_of(job);
  make_folder(output.folder);
  Stopwatch stopwatch;
  ExportReport report;
  progress_stage(progress, "read");
  const ExportSource source = read_export_source(job, output.folder, progress);
  report.input = source.map.report;
  if (source.material) report.roughness = source.material->roughness;
  report.width = source.map.normals.width();
  report.height = source.map.normals.height();
  report.level_count = mip_level_count(report.width, report.height);
  report.textures = texture_list(output);
  report.files = material_files(output, report.width, report.height);
  report.side_warnings = side_warnings(output, report.width, report.height);
  for (const std::string& warning : report.side_warnings) log_warning(warning);
  check_paths_differ(export_inputs(job), report.files);
  report.seconds.emplace_back("read", stopwatch.lap());

  progress_start(progress, static_cast<std::uint64_t>(report.width) * static_cast<std::uint64_t>(report.height));
  report.device = device.info().name;
  std::optional<ExportMeter> meter;
  if (job.measure) meter.emplace(report.width, report.height, job.accuracy, source.lobes.get());
  std::optional<MeterSink> stored;
  if (meter) stored.emplace(*meter);
  const std::unique_ptr<MaterialWriter> writer =
      make_material_folder(output, report.width, report.height, device, stored ? &*stored : nullptr);
  const OneLobeInputs inputs = source.inputs(job);
  report.plan = fit_one_lobe(device, inputs, job.lobe, *writer, progress).plan;
  report.seconds.emplace_back("fit", stopwatch.lap());
  if (meter) {
    report.accuracy = meter->run(inputs, job.lobe, progress);
    report.seconds.emplace_back("measure", stopwatch.lap());
  }
  progress_stage(progress, "write");
  writer->commit();
  report.seconds.emplace_back("write", stopwatch.lap());
  report.launches = device.launch_counts();
  if (!job.report.empty()) write_text_file(job.report, report.to_json(job));
  progress_finish(progress);
  return report;
}

}  // namespace multum
