// SPDX-License-Identifier: Apache-2.0
// multum pack, unpack: inferred textures of an animation as one small file, and back (Hakura et al. 2000, section 4).
#include <cstdio>
#include <memory>

#include "host/base/error.h"
#include "host/base/shown_text.h"
#include "host/codec/field_packing.h"
#include "host/codec/field_unpacking.h"
#include "host/codec/transforms/device_image_transforms.h"
#include "tools/multum/commands.h"

namespace multum {
namespace {

struct PackOptions {
  CommonOptions common;
  FieldPackSettings settings;
  std::string coder = "auto";
  std::string device;
};

struct UnpackOptions {
  CommonOptions common;
  std::string file, folder;
};

int run_pack(PackOptions& o) {
  o.settings.threads = apply(o.common);
  if (o.coder != "auto") o.settings.coder = o.coder == "dct" ? ImageCoder::kDct : ImageCoder::kWavelet;
  Device device = Device::when_needed(DeviceChoice{o.device});
  DeviceImageTransforms transforms(device);
  o.settings.transforms = &transforms;
  const std::unique_ptr<Progress> progress = make_progress(o.common);
  const FieldPackReport report = pack_field(o.settings, progress.get());
  if (o.common.verbose)
    for (const PackedChunkReport& chunk : report.chunks)
      print_shown(stdout, "%8zu bytes, MSE %.3f: layer '%s' of object '%s', block %zu\n", chunk.bytes, chunk.mse,
                  chunk.layer.c_str(), chunk.object.c_str(), chunk.block);
  if (!o.common.quiet)
    print_shown(stdout,
                "%s: written: %llu bytes, %.1f:1 of raw frames; %llu of description, %zu chunks; MSE of about %.2f "
                "beside the textures' own; lambda %.5g, coded %d times\n",
                o.settings.output.c_str(), static_cast<unsigned long long>(report.bytes),
                static_cast<double>(report.raw_bytes) / static_cast<double>(report.bytes),
                static_cast<unsigned long long>(report.description_bytes), report.chunks.size(), report.mse,
                report.lambda, report.rounds);
  return 0;
}

int run_unpack(const UnpackOptions& o) {
  const int threads = apply(o.common);
  const std::unique_ptr<Progress> progress = make_progress(o.common);
  const UnpackReport report = unpack_field(o.file, o.folder, threads, progress.get());
  if (!o.common.quiet)
    print_shown(stdout, "%s: written: %zu textures of %zu chunks\n", o.folder.c_str(), report.textures, report.chunks);
  if (report.damaged.empty()) return 0;
  std::string text = "left out, all else is unpacked:";
  for (const std::string& damaged : report.damaged) text += "\n  " + damaged;
  throw Error(ErrorCode::kVerification, text);
}

void add_pack(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<PackOptions>();
  PackOptions& o = *options;
  CLI::App* pack =
      app.add_subcommand("pack", "compress the textures of `multum infer` to one file (docs/ANIMATION.md)");
  pack->add_option("folder", o.settings.folder, "folder that `multum infer` wrote")->required();
  pack->add_option("-o,--output", o.settings.output, "file to write, *.mpt")->required();
  FieldTarget& t = o.settings.target;
  const std::vector<CLI::Option*> targets = {
      pack->add_option("--ratio", t.ratio, "bytes of raw 24-bit frames over the file's, at least; 384 without a target")
          ->check(CLI::Range(1.0, 1e6)),
      pack->add_option("--bytes", t.bytes, "bytes of the file, at most")->check(CLI::Range(1.0, 1e15)),
      pack->add_option(
              "--mse-max", t.mse,
              "mean squared error that coding may add to drawn frames, as estimated, in 8-bit units at gamma 2.2")
          ->check(CLI::Range(1e-3, 65025.0)),
      pack->add_option("--lambda", t.lambda, "squared error that a bit is worth")->check(CLI::Range(1e-4, 1e9))};
  for (CLI::Option* one : targets)
    for (CLI::Option* other : targets)
      if (one != other) one->excludes(other);
  pack->add_option("--coder", o.coder, "image coder of all chunks: cosines or wavelets; auto: of each the better one")
      ->check(CLI::IsMember({"auto", "dct", "wavelet"}))
      ->capture_default_str();
  pack->add_option("--block", o.settings.block, "samples of a chunk along a parameter, at most")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  pack->add_option("--device", o.device, "OpenCL device: its number in `multum devices`, or part of its name");
  add_common_options(*pack, o.common);
  pack->callback([options, exit_code] { *exit_code = run_pack(*options); });
}

void add_unpack(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<UnpackOptions>();
  CLI::App* unpack =
      app.add_subcommand("unpack", "textures and manifest of a packed field, as `multum infer` has them");
  unpack->add_option("file", options->file, "a packed field, *.mpt")->required();
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
