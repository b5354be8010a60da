// SPDX-License-Identifier: Apache-2.0
// Implements multum export, which writes a normal map as a material with one lobe per texel. Engines can load this
// material without a new shader.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>

#include "host/delivery/export/baked_lobes.h"
#include "host/delivery/export/batch/export_batch.h"
#include "host/delivery/export/batch/export_manifest.h"
#include "host/delivery/export/export_job.h"
#include "host/delivery/export/lobes/lobe_export.h"
#include "host/delivery/export/report/export_page.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/system_failure.h"
#include "host/foundation/base/work_shard.h"
#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/engine_presets.h"
#include "host/foundation/parameters/export_parameters.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/check/verdict_line.h"
#include "tools/multum/commands.h"
#include "tools/multum/compared_bake.h"
#include "tools/multum/json_output.h"
#include "tools/multum/map_turns.h"

namespace multum {
namespace {

struct ExportOptions {
  CommonOptions common;
  ExportJob job;
  ParameterValues values{export_parameters()};
  std::vector<std::string> inputs;
  std::string manifest;  // manifest file; empty if the command runs in another mode
  bool check = false, dry_run = false;
  std::string shard_text;
  WorkShard shard;  // share of several maps
};

const char* finding_name(ExportFinding finding) {
  switch (finding) {
    case ExportFinding::kInPlace: return "unchanged";
    case ExportFinding::kMissing: return "missing";
    case ExportFinding::kStale: return "stale";
    case ExportFinding::kDamaged: return "damaged";
  }
  return "";
}

// Throws Error(kUsage) for options that control how a map is read. They have no effect on a baked file, which already
// holds decoded normals.
void check_no_reading_is_given(const std::string& input, const ParameterValues& values) {
  for (const Parameter& row : export_parameters().rows())
    if (row.group == kSourceGroup && values.has(row.name))
      throw Error(ErrorCode::kUsage,
                  input + " is a baked file, whose normals are already decoded; expected no " + row.option());
}

// Returns a line for each engine.
std::string presets_text() {
  std::string text;
  for (const auto& [name, engine] : kEngines)
    text += fmt::format("  {:<11} {}\n", name, preset_text(preset_of(engine)));
  return text;
}

ExportReport export_with_page(ExportJob job, const std::string& page, const CommonOptions& common, Device& device) {
  const auto progress = make_progress(common);
  if (page.empty()) return export_file(job, device, progress.get());
  check_paths_differ(input_files(job), {page, job.report});
  check_writable(page);
  std::optional<ComparedBake> bake;
  if (job.lobes.empty() && job.measure && !is_baked_name(job.input)) {
    bake.emplace(job, page, device, progress.get());
    job.lobes = bake->path();
  }
  const ExportReport report = export_file(job, device, progress.get());
  write_export_page(job, report, page, device, progress.get());
  return report;
}

void print_export(const ExportJob& job, const CommonOptions& common, const ExportReport& report,
                  std::FILE* out = stdout) {
  if (!prints_text(common)) return;
  print_shown(out, "%s: %d levels of %d x %d, %zu files: %s\n", job.output.c_str(), report.level_count, report.width,
              report.height, report.files.size(), report.textures.c_str());
  if (!report.preset_line.empty()) print_shown(out, "%s: %s\n", job.output.c_str(), report.preset_line.c_str());
  if (!report.engine_line.empty()) print_shown(out, "%s: %s\n", job.output.c_str(), report.engine_line.c_str());
  if (!common.verbose) return;
  if (report.form) print_shown(out, "%s: %s\n", job.output.c_str(), report.form->to_text(false).c_str());
  print_shown(out, "%s", report.accuracy.to_text().c_str());
  if (report.rows_resumed > 0)
    print_shown(out, "%llu level rows were reused from an interrupted export\n",
                static_cast<unsigned long long>(report.rows_resumed));
  print_shown(out, "%s", report.plan.c_str());
  for (const auto& [stage, seconds] : report.seconds) print_shown(out, "%s %.2f s\n", stage.c_str(), seconds);
}

// Returns "output", then the keys of --report.
OrderedJson export_json(const ExportJob& job, const ExportReport& report) {
  OrderedJson json = {{"output", path_json(job.output)}};
  json.update(parsed(report.to_json(job)));
  return json;
}

// Returns the number of maps that are exported at the same time. With --verbose, times of stages are printed, which
// have a meaning only if no other map is exported. A GPU is not shared.
int maps_at_once(const std::vector<ExportJob*>& jobs, const CommonOptions& common, const Device& device) {
  if (jobs.size() < 2 || common.verbose || !device.info().is_cpu) return 1;
  return share_memory(jobs);
}

// The result of one of several maps.
struct ExportedMap {
  OrderedJson json;
  int failure = 0;  // exit code
};

// Exports one of several maps. If it fails, the others are still exported.
ExportedMap export_one(ExportJob job, const CommonOptions& common, const MapTurn& turn) {
  job.threads = turn.threads;
  try {
    const ExportReport report = export_file(job, turn.device, turn.progress);
    print_export(job, common, report, turn.out);
    return {with_verdict(export_json(job, report), end_with_verdict(job, report, common, turn.device, turn.out))};
  } catch (...) {
    const Error error = caught_error(job.input);
    print_shown(turn.err, "multum: %s\n", error.what());
    return {{{"output", path_json(job.output)}, {"input", path_json(job.input)}, {"failed", error.what()}},
            exit_code(error.code())};
  }
}

// Returns the exit code of the first failure.
int export_several(std::vector<ExportJob> jobs, const CommonOptions& common, const DeviceChoice& choice,
                   Device& device) {
  std::vector<ExportJob*> all;
  for (ExportJob& job : jobs) all.push_back(&job);
  std::vector<ExportedMap> results(jobs.size());
  const MapTurns turns{jobs.size(), maps_at_once(all, common, device), jobs.empty() ? 1 : jobs.front().threads, choice};
  for_each_map(turns, common, device,
               [&](const MapTurn& turn) { results[turn.map] = export_one(jobs[turn.map], common, turn); });
  int code = 0;
  std::size_t failed = 0;
  OrderedJson maps = OrderedJson::array();
  for (ExportedMap& result : results) {
    failed += result.failure != 0 ? 1 : 0;
    if (code == 0) code = result.failure;
    maps.push_back(std::move(result.json));
  }
  if (prints_text(common) || failed > 0)
    print_shown(failed > 0 ? stderr : stdout, "%zu maps: %zu exported, %zu failed\n", jobs.size(), jobs.size() - failed,
                failed);
  if (common.json) print_json({{"maps", maps}});
  return code;
}

// The result of one map of a manifest.
struct ManifestOutcome {
  OrderedJson json;
  bool exported = false, unchanged = false, finding = false;
  int failure = 0;  // exit code
};

// Exports one map of a manifest. Prints findings of --check to stderr.
ManifestOutcome export_of_manifest(ManifestExport map, const ExportOptions& o, const MapTurn& turn) {
  map.job.threads = turn.threads;
  ManifestOutcome outcome;
  try {
    const ManifestExportResult result = run_manifest_export(map, o.dry_run, turn.device, turn.progress);
    outcome.json = {{"name", map.name}, {"state", finding_name(result.found.finding)}};
    if (!result.found.why.empty()) outcome.json["why"] = result.found.why;
    if (result.report) {
      print_export(map.job, o.common, *result.report, turn.out);
      outcome.json["report"] = with_verdict(export_json(map.job, *result.report),
                                            end_with_verdict(map.job, *result.report, o.common, turn.device, turn.out));
      outcome.exported = true;
    }
    if (result.found.finding == ExportFinding::kInPlace && !result.report) {
      if (prints_text(o.common)) print_shown(turn.out, "%s: unchanged\n", map.name.c_str());
      outcome.unchanged = true;
      return outcome;
    }
    if (!o.check) return outcome;
    print_shown(turn.err, "multum: %s: %s: %s%s\n", map.name.c_str(), finding_name(result.found.finding),
                result.found.why.c_str(), result.report ? "; exported now" : "");
    outcome.finding = true;
  } catch (...) {
    const Error error = caught_error(map.job.input);
    print_shown(turn.err, "multum: %s\n", error.what());
    // A setting that does not suit its map is an error in the manifest, not in the command line.
    return {{{"name", map.name}, {"state", "failed"}, {"why", error.what()}},
            false,
            false,
            false,
            exit_code(error.code() == ErrorCode::kUsage ? ErrorCode::kInput : error.code())};
  }
  return outcome;
}

int run_export_manifest(const ExportOptions& o) {
  std::vector<ManifestExport> maps = pieces_of(o.shard, read_export_manifest(o.manifest, o.job));
  const DeviceChoice choice{o.values.text("device").value_or("")};
  Device device = Device::when_needed(choice);
  std::vector<ExportJob*> all;
  for (ManifestExport& map : maps) all.push_back(&map.job);
  std::vector<ManifestOutcome> outcomes(maps.size());
  const MapTurns turns{maps.size(), maps_at_once(all, o.common, device), o.job.threads, choice};
  for_each_map(turns, o.common, device,
               [&](const MapTurn& turn) { outcomes[turn.map] = export_of_manifest(maps[turn.map], o, turn); });
  int code = 0;
  std::size_t unchanged = 0, exported = 0, findings = 0;
  OrderedJson shown = OrderedJson::array();
  for (ManifestOutcome& outcome : outcomes) {
    unchanged += outcome.unchanged ? 1 : 0;
    exported += outcome.exported ? 1 : 0;
    findings += outcome.finding ? 1 : 0;
    if (code == 0) code = outcome.failure;
    shown.push_back(std::move(outcome.json));
  }
  const std::size_t failed = maps.size() - unchanged - exported - (o.dry_run ? findings : 0);
  if (prints_text(o.common) || failed > 0)
    print_shown(failed > 0 ? stderr : stdout, "%zu maps: %zu exported, %zu unchanged, %zu failed\n", maps.size(),
                exported, unchanged, failed);
  if (code == 0 && findings > 0) code = exit_code(ErrorCode::kVerification);
  if (o.common.json) print_json({{"manifest", path_json(o.manifest)}, {"passed", code == 0}, {"maps", shown}});
  return code;
}

// Throws Error(kUsage) for an option that the manifest sets for each map.
void check_no_map_is_given(const ExportOptions& o) {
  if (!o.inputs.empty() || !o.job.output.empty())
    throw Error(ErrorCode::kUsage,
                "input, --output and --manifest are mutually exclusive, because the manifest names the maps");
  for (const Parameter& row : export_parameters().rows())
    if ((row.is_on(kInManifest) || row.name == "report" || row.name == "page") && o.values.has(row.name))
      throw Error(ErrorCode::kUsage, row.option() + " and --manifest are mutually exclusive, expected " + row.name +
                                         " under [[map]] or [defaults] in " + o.manifest);
}

LobeExportJob lobe_export_job(const ExportOptions& o) {
  if (!o.manifest.empty() || o.inputs.size() != 1)
    throw Error(ErrorCode::kUsage,
                fmt::format("--lobes: found {}, expected one baked file",
                            o.manifest.empty() ? fmt::format("{} inputs", o.inputs.size()) : "--manifest"));
  if (!o.shard_text.empty()) throw Error(ErrorCode::kUsage, "--lobes: found --shard, which is for several maps");
  constexpr std::array kWithLobes = {"lobes", "force", "texels", "zstd", "device", "report"};
  for (const Parameter& row : export_parameters().rows())
    if (o.values.has(row.name) && std::find(kWithLobes.begin(), kWithLobes.end(), row.name) == kWithLobes.end())
      throw Error(ErrorCode::kUsage,
                  "--lobes: found " + row.option() +
                      ", which has no effect because lobes are stored unchanged; expected it only without --lobes");
  LobeExportJob job{o.inputs[0], o.job.output, o.values.text("report").value_or("")};
  if (!o.job.output.ends_with(".ktx2"))
    throw Error(ErrorCode::kUsage, o.job.output + ": is not the name of a KTX2 file, expected NAME.ktx2 with --lobes");
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
  if (o.common.json) {
    OrderedJson json = {{"output", path_json(job.output)}};
    json.update(parsed(report.to_json()));
    print_json(json);
  }
  if (!prints_text(o.common)) return 0;
  print_shown(
      stdout,
      "%s: written: %zu lobes, %d layers, levels from %d on, %.1f MB on the GPU, %.2f times the size of BC5 and BC4\n",
      job.output.c_str(), report.header.lobes.size(), report.header.layer_count(), report.header.map.first_level,
      static_cast<double>(report.gpu_bytes) / 1e6, report.bytes_ratio());
  for (const auto& [stage, seconds] : report.seconds)
    if (o.common.verbose) print_shown(stdout, "%s %.2f s\n", stage.c_str(), seconds);
  return 0;
}

int run_export(ExportOptions& o) {
  const bool has_manifest = !o.manifest.empty();
  if (has_manifest) check_no_map_is_given(o);
  else if (o.inputs.empty() || o.job.output.empty()) throw CLI::RequiredError(o.inputs.empty() ? "input" : "--output");
  if (o.values.flag("lobes")) return run_lobe_export(o);
  o.job.threads = apply(o.common);
  keep_freed_memory();
  apply(o.values, o.job);
  o.job.keeps_mosaic = o.job.measure && !o.common.quiet;
  if (!o.shard_text.empty()) o.shard = parse_work_shard("--shard", o.shard_text);
  if (has_manifest) add_key_words(export_parameters().names(kInManifest));
  if (has_manifest) return run_export_manifest(o);
  for (const std::string& input : o.inputs)
    if (is_baked_name(input)) check_no_reading_is_given(input, o.values);
  const std::vector<ExportJob> all = make_export_jobs(o.job, o.inputs);
  if (all.size() == 1 && !o.shard_text.empty())
    throw Error(ErrorCode::kUsage, "found --shard with one map, expected several maps, a set or a manifest");
  const std::string page = o.values.text("page").value_or("");
  if (all.size() > 1 && !page.empty())
    throw Error(ErrorCode::kUsage, "found --page with several maps, expected one map");
  const DeviceChoice choice{o.values.text("device").value_or("")};
  Device device = Device::when_needed(choice);
  if (all.size() > 1) return export_several(pieces_of(o.shard, all), o.common, choice, device);
  const ExportReport report = export_with_page(all[0], page, o.common, device);
  print_export(all[0], o.common, report);
  const std::optional<GainVerdict> verdict = end_with_verdict(all[0], report, o.common, device);
  if (o.common.json) print_json(with_verdict(export_json(all[0], report), verdict));
  return 0;
}

}  // namespace

void add_export_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<ExportOptions>();
  ExportOptions& o = *options;
  CLI::App* command = app.add_subcommand("export",
                                         "write normal maps as textures for engines: normal, roughness and anisotropy "
                                         "with fitted mips");
  command->add_option("input", o.inputs,
                      "normal map, height field or baked file with level 0 (NAME.ndf.exr); also several maps, or a "
                      "tile set such as rock_<UDIM>.png");
  command->add_option("-o,--output", o.job.output,
                      "output folder, or NAME.ktx2 or NAME.dds, which gives NAME_normal.ktx2, NAME_orm.ktx2 and so on;"
                      " for several maps, a folder or a name with <UDIM>");
  CLI::Option* const manifest =
      command->add_option("--manifest", o.manifest,
                          "export the changed maps in this maps.toml; this option replaces the input and "
                          "--output");
  CLI::Option* const check = command
                                 ->add_flag("--check", o.check,
                                            "list files that were missing, stale or damaged, and exit with code 5 if "
                                            "there are any")
                                 ->needs(manifest);
  command->add_flag("--dry-run", o.dry_run, "with --check, list the findings, but export nothing")->needs(check);
  command->add_option("--shard", o.shard_text,
                      "export only share I of N (I/N), or shares I to J (I-J/N), of several maps");
  add_parameter_options(*command, o.values);
  check->excludes("--force");
  add_common_options(*command, o.common);
  add_decoding_option(*command);
  command->footer(
      "Examples:\n"
      "  multum export bricks_n.png -o bricks/                      # normal_00.png, orm_00.png and so on\n"
      "  multum export bricks_n.png -o bricks.ktx2 --zstd 15        # bricks_normal.ktx2, bricks_orm.ktx2, all levels\n"
      "  multum export bricks.ndf.exr --lobes -o bricks.ktx2        # lobes of multum bake for GPUs\n"
      "  multum export bricks_n.png --for unreal -o bricks.dds      # T_bricks_N.dds, T_bricks_ORM.dds, green down\n"
      "  multum export 'rock_<UDIM>.png' -o 'rock_<UDIM>.ktx2'      # all tiles of a set\n"
      "  multum export --manifest materials.toml                    # the changed maps of a project\n"
      "--page bakes lobes for its comparison unless --beside names a baked file.\n\n"
      "Settings of --for, which other options replace:\n" +
      presets_text() + "docs/how-to/export_to_engine.md lists the steps for each engine.");
  command->callback([options, exit_code] { *exit_code = run_export(*options); });
}

}  // namespace multum
