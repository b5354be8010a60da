// SPDX-License-Identifier: Apache-2.0
// Implements multum pack, which compresses the inferred textures of an animation into one file, and multum unpack,
// which decompresses this file (Hakura et al. 2000, section 4).
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "host/fields/codec/field_unpacking.h"
#include "host/fields/codec/packing/field_packing.h"
#include "host/fields/codec/transforms/device_image_transforms.h"
#include "host/fields/inferred/inference_error.h"
#include "host/fields/player/player_output.h"
#include "host/foundation/base/choices.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/parameters/pack_parameters.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/fields/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

struct PackOptions {
  CommonOptions common;
  FieldPackSettings settings;
  PlayerOutput player;
  ParameterValues values{pack_parameters()};
  std::string device;
};

struct UnpackOptions {
  CommonOptions common;
  std::string file, folder;
};

void apply(const ParameterValues& values, FieldPackSettings& settings) {
  settings.alpha = values.number("alpha").value_or(settings.alpha);
  if (settings.alpha != 0.0 && settings.alpha <= 1.0)
    throw Error(ErrorCode::kUsage, fmt::format("--alpha is {:g}, expected a number above 1, or 0", settings.alpha));
  settings.pyramid = values.choice("pyramid", kPyramidChoices).value_or(settings.pyramid);
  const std::string coder = values.text("coder").value_or("auto");
  if (coder != "auto") settings.coder = coder == "dct" ? ImageCoder::kDct : ImageCoder::kWavelet;
  settings.open_loop = values.text("loop") == "open";
  settings.target.ratio = values.number("ratio");
  if (const auto bytes = values.bytes("bytes")) settings.target.bytes = static_cast<double>(*bytes);
  settings.target.mse = values.number("mse_max");
  settings.target.lambda = values.number("lambda");
  settings.block = values.integer("block").value_or(settings.block);
  settings.stagger = values.text("stagger") == "yes";
  if (const auto bytes = values.bytes("memory")) settings.memory_bytes = static_cast<std::uint64_t>(*bytes);
  settings.resume = values.flag("resume");
  settings.has_absolute_geometry = values.flag("absolute_geometry");
}

// Returns FOLDER for "FOLDER/inferred.json", which is the form in jobs of the service.
std::string field_folder(const std::string& named) {
  const std::filesystem::path path(named);
  if (path.filename() != kInferredManifestName || std::filesystem::is_directory(path)) return named;
  return path.has_parent_path() ? path.parent_path().string() : ".";
}

void print_parts(const FieldPackReport& report) {
  if (report.chunks_resumed > 0)
    print_shown(stdout, "%zu chunks were reused from an interrupted run\n", report.chunks_resumed);
  for (const PackedObjectReport& object : report.objects)
    print_shown(stdout, "object '%s': its pixels have an MSE of %.3f, %.2f times the mean; lambda %.5g\n",
                object.object.c_str(), object.mse, object.mse / report.mse_covered, object.lambda);
  for (const PackedChunkReport& chunk : report.chunks)
    print_shown(stdout, "%8zu bytes, MSE %.3f: layer '%s' of object '%s', block %zu\n", chunk.bytes, chunk.mse,
                chunk.layer.c_str(), chunk.object.c_str(), chunk.block);
}

void warn_of_errors(const PackOptions& o, const FieldPackReport& report) {
  if (!report.is_alpha_met)
    log_warning(
        o.settings.output,
        fmt::format("the error of an object exceeds --alpha {:g} times the mean error; --verbose lists the objects",
                    o.settings.alpha));
  if (!report.inferred_mse && o.settings.target.is_default())
    log_warning(o.settings.output,
                fmt::format("{}/{} does not state the error of the inferred textures, so packing at {:g}:1 added an "
                            "MSE of about {:.3g}, which could not be checked. Run multum infer again, or choose a size "
                            "or an error with --ratio, --bytes or --mse-max",
                            o.settings.folder, kInferenceReportName, kDefaultRatio, report.mse));
  if (report.is_error_large)
    log_warning(o.settings.output,
                fmt::format("packing adds an MSE of about {:.3g}, which is {:.3g} times the error of the inferred "
                            "textures ({:.3g}). {}",
                            report.mse, report.mse / std::max(*report.inferred_mse, 1e-9), *report.inferred_mse,
                            o.settings.target.is_default()
                                ? "No smaller error was found, although the factor should stay below 3"
                                : "Without --ratio, --bytes and --lambda, the factor stays below 3"));
}

OrderedJson pack_json(const PackOptions& o, const FieldPackReport& report) {
  OrderedJson json = {{"output", path_json(o.settings.output)},
                      {"bytes", report.bytes},
                      {"raw_bytes", report.raw_bytes},
                      {"description_bytes", report.description_bytes},
                      {"mse_added", report.mse},
                      {"lambda", report.lambda},
                      {"rounds", report.rounds},
                      {"chunks_resumed", report.chunks_resumed},
                      {"is_alpha_met", report.is_alpha_met},
                      {"is_error_large", report.is_error_large},
                      {"objects", OrderedJson::array()},
                      {"chunks", OrderedJson::array()}};
  if (report.inferred_mse) json["inferred_mse"] = *report.inferred_mse;
  for (const PackedObjectReport& object : report.objects)
    json["objects"].push_back({{"object", object.object}, {"mse", object.mse}, {"lambda", object.lambda}});
  for (const PackedChunkReport& chunk : report.chunks)
    json["chunks"].push_back({{"object", chunk.object},
                              {"layer", chunk.layer},
                              {"block", chunk.block},
                              {"bytes", chunk.bytes},
                              {"mse", chunk.mse}});
  return json;
}

int run_pack(PackOptions& o) {
  o.settings.threads = apply(o.common);
  apply(o.values, o.settings);
  o.settings.folder = field_folder(o.settings.folder);
  check_paths_differ({}, {o.settings.output, o.player.folder, o.player.page});
  check_player_output(o.player);
  Device device = Device::when_needed(DeviceChoice{o.device});
  DeviceImageTransforms transforms(device);
  o.settings.transforms = &transforms;
  const std::unique_ptr<Progress> progress = make_progress(o.common);
  const FieldPackReport report = pack_field(o.settings, progress.get());
  if (o.common.verbose && !o.common.json) print_parts(report);
  warn_of_errors(o, report);
  if (prints_text(o.common))
    print_shown(stdout,
                "%s: written: %llu bytes, %.1f:1 of raw frames; %llu bytes of description, %zu chunks; adds an MSE of "
                "about %.2f; lambda %.5g, coded %d times\n",
                o.settings.output.c_str(), static_cast<unsigned long long>(report.bytes),
                static_cast<double>(report.raw_bytes) / static_cast<double>(report.bytes),
                static_cast<unsigned long long>(report.description_bytes), report.chunks.size(), report.mse,
                report.lambda, report.rounds);
  if (prints_text(o.common) && report.has_given_way)
    print_shown(stdout,
                "%s: a ratio of %g:1 would add an error of more than %g times the error of the inferred textures (MSE "
                "%.3g), so the file is larger than this ratio requires; --ratio %g forces the ratio\n",
                o.settings.output.c_str(), kDefaultRatio, kAddedErrorMax, *report.inferred_mse, kDefaultRatio);
  write_player(o.settings.output, o.player);
  for (const std::string& written : {o.player.folder, o.player.page})
    if (!written.empty() && prints_text(o.common)) print_shown(stdout, "%s: written: the player\n", written.c_str());
  if (o.common.json) print_json(pack_json(o, report));
  return 0;
}

int run_unpack(const UnpackOptions& o) {
  const int threads = apply(o.common);
  const std::unique_ptr<Progress> progress = make_progress(o.common);
  const UnpackReport report = unpack_field(o.file, o.folder, threads, progress.get());
  if (o.common.json)
    print_json({{"output", path_json(o.folder)},
                {"textures", report.textures},
                {"chunks", report.chunks},
                {"damaged", report.damaged}});
  if (prints_text(o.common))
    print_shown(stdout, "%s: written: %zu textures of %zu chunks\n", o.folder.c_str(), report.textures, report.chunks);
  if (report.damaged.empty()) return 0;
  std::string text = "damaged chunks were left out, and everything else was unpacked:";
  for (const std::string& damaged : report.damaged) text += "\n  " + damaged;
  throw Error(ErrorCode::kVerification, text);
}

void add_pack(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<PackOptions>();
  PackOptions& o = *options;
  CLI::App* pack = app.add_subcommand(
      "pack", "compress the textures that `multum infer` wrote into one file (docs/reference/animation_jobs.md)");
  pack->footer(
      "Example:\n"
      "  multum pack inferred -o field.mpt --page field.html\n"
      "Give at most one of --ratio, --bytes, --mse-max and --lambda. With --lambda, chunks are coded\n"
      "only once. A page holds at most 16 MiB of field and geometry. If --memory is too small for one chunk, an\n"
      "error says how much is needed. Threads, memory and device do not change the file.");
  pack->add_option("folder", o.settings.folder, "folder written by `multum infer`, or its inferred.json")->required();
  pack->add_option("-o,--output", o.settings.output, "file to write, *.mpt")->required();
  pack->add_option("--player", o.player.folder,
                   "also write a player for browsers to this folder, which any static web server can serve");
  pack->add_option("--page", o.player.page, "also write this page, *.html: player, field and geometry in one file");
  add_parameter_options(*pack, o.values);
  pack->add_option("--device", o.device, "use this OpenCL device: its number in `multum devices`, or part of its name");
  add_common_options(*pack, o.common);
  pack->callback([options, exit_code] { *exit_code = run_pack(*options); });
}

void add_unpack(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<UnpackOptions>();
  CLI::App* unpack =
      app.add_subcommand("unpack", "decompress a packed field to the textures and manifest of `multum infer`");
  unpack->footer(
      "Example:\n"
      "  multum unpack field.mpt -o unpacked\n"
      "The command refuses a folder that already contains an inferred.json.");
  unpack->add_option("file", options->file, "packed field, *.mpt")->required();
  unpack->add_option("-o,--output", options->folder, "folder to write to")->required();
  add_common_options(*unpack, options->common);
  unpack->callback([options, exit_code] { *exit_code = run_unpack(*options); });
}

}  // namespace

void add_pack_commands(CLI::App& app, int* exit_code) {
  add_pack(app, exit_code);
  add_unpack(app, exit_code);
}

}  // namespace multum
