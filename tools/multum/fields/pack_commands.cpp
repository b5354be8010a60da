// SPDX-License-Identifier: Apache-2.0
// Implements multum pack, which compresses the inferred textures of an animation into one file, and multum unpack,
// which decompresses this file (Hakura et al. 2000, section 4).
#include <cstdio>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "host/fields/codec/field_unpacking.h"
#include "host/fields/codec/packing/pack_job.h"
#include "host/fields/codec/transforms/device_image_transforms.h"
#include "host/fields/player/player_output.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
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
  warn_of_pack_errors(o.settings, report);
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
  if (o.common.json) print_json(parsed(pack_report_json(o.settings, report)));
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
