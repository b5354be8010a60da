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
  return inputs;
}

MaterialFolderSettings folder_of(const ExportJob& job) { return {job.output, job.format, job.lobe.is_anisotropic}; }

void check_export_job(const ExportJob& job) {
  validate(job.lobe);
  for (const char* extension : {".ktx2", ".dds", ".png", ".exr", ".glb", ".gltf"})
    if (job.output.ends_with(extension))
      throw Error(
          ErrorCode::kUsage,
          fmt::format("{}: is a name of a file, expected a folder: a material is several textures; --format says "
                      "of which kind",
                      job.output));
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

ExportSource read_export_source(const ExportJob& job, Progress* progress) {
  InputHashes hashes;
  for (const std::string& file : export_inputs(job)) hashes.note(file);
  const SpillPolicy spill = {job.scratch_folder.empty() ? job.output : job.scratch_folder,
                             static_cast<std::int64_t>(job.memory_bytes / 4)};
  ExportSource source{read_normal_map_rows(job.input, job.reading, spill, job.threads, progress), std::nullopt};
  if (export_inputs(job).size() > 1)
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

// Rounds rows, shows them to the measurement and writes them.
class RoundingMaterialSink : public MaterialSink {
 public:
  RoundingMaterialSink(MaterialEncoding encoding, ExportMeter* meter, MaterialWriter& writer)
      : encoding_(encoding), meter_(meter), writer_(writer) {}
  void add_level(int level, int first_row, MaterialRows rows) override {
    round_material(rows, encoding_);
    if (meter_ != nullptr) meter_->add_rows(level, first_row, rows);
    writer_.add_level(level, first_row, std::move(rows));
  }

 private:
  const MaterialEncoding encoding_;
  ExportMeter* const meter_;
  MaterialWriter& writer_;
};

}  // namespace

std::string ExportReport::to_json(const ExportJob& job) const {
  nlohmann::ordered_json json = {{"width", width},
                                 {"height", height},
                                 {"levels", level_count},
                                 {"format", input.format},
                                 {"encoding", input.encoding},
                                 {"warnings", input.warnings},
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
  make_folder(job.output);
  Stopwatch stopwatch;
  ExportReport report;
  progress_stage(progress, "read");
  const ExportSource source = read_export_source(job, progress);
  report.input = source.map.report;
  if (source.material) report.roughness = source.material->roughness;
  report.width = source.map.normals.width();
  report.height = source.map.normals.height();
  report.level_count = mip_level_count(report.width, report.height);
  report.files = material_files(folder_of(job), report.width, report.height);
  check_paths_differ(export_inputs(job), report.files);
  report.seconds.emplace_back("read", stopwatch.lap());

  progress_start(progress, static_cast<std::uint64_t>(report.width) * static_cast<std::uint64_t>(report.height));
  report.device = device.info().name;
  const std::unique_ptr<MaterialWriter> writer = make_material_folder(folder_of(job), report.width, report.height);
  std::optional<ExportMeter> meter;
  if (job.measure) meter.emplace(report.width, report.height, job.accuracy);
  RoundingMaterialSink sink(encoding_of(job.format), meter ? &*meter : nullptr, *writer);
  const OneLobeInputs inputs = source.inputs(job);
  report.plan = fit_one_lobe(device, inputs, job.lobe, sink, progress).plan;
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
