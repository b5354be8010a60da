// SPDX-License-Identifier: Apache-2.0
// Implements multum look, which writes a page that shows lobes next to the results of engines, and opens this page on a
// desktop.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "host/delivery/look/look_page.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/child_process.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/shown_text.h"
#include "tools/multum/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

struct LookOptions {
  CommonOptions common;
  LookJob job;
  std::vector<std::string> inputs, sources;
  std::string device;
  bool stays_closed = false;
};

bool has_desktop() { return std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr; }

int run_look(LookOptions& o) {
  o.job.threads = apply(o.common);
  keep_freed_memory();
  if (!o.sources.empty() && o.sources.size() != o.inputs.size())
    throw Error(ErrorCode::kUsage,
                fmt::format("found {} --source, expected none, or one for each of the {} files in the same order",
                            o.sources.size(), o.inputs.size()));
  for (std::size_t i = 0; i < o.inputs.size(); ++i)
    o.job.maps.push_back({o.inputs[i], o.sources.empty() ? "" : o.sources[i]});
  if (o.job.output.empty()) {
    const std::string name = std::filesystem::path(o.inputs[0]).filename().string();
    o.job.output = o.inputs.size() > 1 ? "look.html" : name.substr(0, name.find('.')) + ".html";
  }
  if (!o.job.output.ends_with(".html"))
    throw Error(ErrorCode::kUsage, o.job.output + ": is not the name of a page, expected NAME.html");
  Device device = Device::when_needed({o.device});
  const auto progress = make_progress(o.common);
  write_look_page(o.job, device, progress.get());
  const std::string path = std::filesystem::absolute(o.job.output).string();
  const bool opens = has_desktop() && !o.stays_closed;
  const auto bytes = static_cast<std::uint64_t>(std::filesystem::file_size(o.job.output));
  if (o.common.json) print_json({{"output", path_json(path)}, {"bytes", bytes}, {"maps", o.job.maps.size()}});
  if (prints_text(o.common))
    print_shown(stdout, "%s: written: %.1f MB; %s\n", path.c_str(), static_cast<double>(bytes) / 1e6,
                opens ? "opening it" : "open it in a browser with WebGL 2");
  if (opens && run_child({"xdg-open", path}).exit_code != 0)
    throw Error(ErrorCode::kEnvironment, path + ": was written, but xdg-open cannot open it; open it in a browser");
  return 0;
}

}  // namespace

void add_look_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<LookOptions>();
  LookOptions& o = *options;
  CLI::App* command = app.add_subcommand("look",
                                         "show lobes in a browser, and compare them with averaged normals, the "
                                         "roughness rules of engines and the one-lobe export");
  command->add_option("inputs", o.inputs, "baked files of lobes, *.ndf.exr; the page lists them")->required();
  command
      ->add_option("--source", o.sources,
                   "the normal map from which a file was baked; give one per file (default: level 0 of the file)")
      ->allow_extra_args(false);
  command->add_option("-o,--output", o.job.output,
                      "page to write, *.html (default: the name of the input, or look.html for several)");
  command->add_option("--base-roughness", o.job.base_roughness, "set one perceptual roughness for the whole surface")
      ->check(CLI::Range(0.05, 1.0))
      ->capture_default_str();
  command->add_flag("--same-source", o.job.same_source,
                    "reject a normal map that is not the map from which the file "
                    "was baked");
  command->add_flag("--no-open", o.stays_closed, "do not open the page");
  command->add_option("--device", o.device,
                      "use this OpenCL device: its number in `multum devices`, or part of its name");
  add_common_options(*command, o.common);
  command->footer(
      "Examples:\n"
      "  multum look bricks.ndf.exr             # writes bricks.html and opens it\n"
      "  multum look *.ndf.exr -o maps.html     # a page to choose from\n"
      "  multum look bricks.ndf.exr --source bricks_n.png -o look.html --base-roughness 0.2 --no-open\n"
      "The page needs WebGL 2 and no network. It shows two methods at a time with a divider between them. \"Measure\n"
      "error\" compares both with the map, drawn with 144 samples per pixel.\n\n"
      "Files dropped onto the page stay in the browser:\n"
      "- a baked file of lobes (compression none, rle, zips or zip; at most 2048 texels per side); also drop its\n"
      "  normal map if the file has no level 0\n"
      "- a KTX2 file of multum export --lobes without --zstd\n"
      "- a normal map of the same size with 8 bits per channel\n"
      "- a model: NAME.glb, or NAME.gltf with its files (at most a million triangles, no required extensions)\n\n"
      "A dropped baked file has no one-lobe export. --source maps are limited to 2048 texels per side, and all maps\n"
      "together to 4 times 2048 x 2048 texels.");
  command->callback([options, exit_code] { *exit_code = run_look(*options); });
}

}  // namespace multum
