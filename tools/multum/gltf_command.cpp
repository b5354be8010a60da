// SPDX-License-Identifier: Apache-2.0
// Implements multum gltf, which writes a copy of a model whose normal and roughness textures have fitted mips.
#include <cstdio>
#include <memory>

#include "host/delivery/gltf/gltf_job.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/parameters/gltf_parameters.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

struct GltfOptions {
  CommonOptions common;
  GltfJob job;
  ParameterValues values{gltf_parameters()};
};

int run_gltf(GltfOptions& o) {
  o.job.threads = apply(o.common);
  keep_freed_memory();
  apply(o.values, o.job);
  Device device = Device::when_needed({o.values.text("device").value_or("")});
  const auto progress = make_progress(o.common);
  const GltfReport report = convert_gltf(o.job, device, progress.get());
  if (o.common.json) {
    OrderedJson json = {{"output", path_json(o.job.output)}};
    json.update(parsed(report.to_json(o.job)));
    print_json(json);
  }
  if (!prints_text(o.common)) return 0;
  const auto megabytes = [](std::uint64_t bytes) { return 1e-6 * static_cast<double>(bytes); };
  print_shown(stdout, "%s: written; %d of %zu materials fitted, %zu set%s of textures; %.2f MB instead of %.2f MB\n",
              o.job.output.c_str(), report.fitted_count(), report.materials.size(), report.textures.size(),
              report.textures.size() == 1 ? "" : "s", megabytes(report.bytes_after), megabytes(report.bytes_before));
  for (const GltfReport::Material& material : report.materials) {
    if (!material.kept.empty())
      print_shown(stdout, "  %s: unchanged: %s\n", material.name.c_str(), material.kept.c_str());
    if (!material.form.empty()) print_shown(stdout, "  %s: %s\n", material.name.c_str(), material.form.c_str());
    for (const std::string& note : material.notes)
      print_shown(stdout, "  %s: %s\n", material.name.c_str(), note.c_str());
    if (material.textures >= 0)
      print_shown(stdout, "  %s: %s\n", material.name.c_str(),
                  report.textures[static_cast<std::size_t>(material.textures)].storage_text().c_str());
  }
  if (!o.common.verbose) return 0;
  for (const auto& [stage, seconds] : report.seconds) print_shown(stdout, "%s %.2f s\n", stage.c_str(), seconds);
  return 0;
}

}  // namespace

void add_gltf_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<GltfOptions>();
  GltfOptions& o = *options;
  CLI::App* command = app.add_subcommand(
      "gltf", "fit better mips for the normal and roughness textures of a model (docs/reference/gltf.md)");
  command->footer(
      "Examples:\n"
      "  multum gltf helmet.glb -o helmet_mips.glb\n"
      "  multum gltf helmet.glb --lobes -o helmet_lobes.glb\n"
      "  multum gltf scene/scene.gltf -o scene.glb --format rgba8 --report scene.json\n"
      "The rest of the model stays unchanged. --format auto stores a texture as uastc if uastc adds less than 0.3\n"
      "points to the picture error, otherwise as rgba8 with a PNG fallback. Node.js encodes uastc with\n"
      "ktx2-encoder. With --lobes and a --form other than auto, all materials get lobes.");
  command->add_option("input", o.job.input, "model to read: *.glb, or *.gltf with its files")->required();
  command->add_option("-o,--output", o.job.output, "model to write: *.glb")->required();
  add_parameter_options(*command, o.values);
  add_common_options(*command, o.common);
  add_decoding_option(*command);
  command->callback([options, exit_code] { *exit_code = run_gltf(*options); });
}

}  // namespace multum
