// SPDX-License-Identifier: Apache-2.0
// Implements multum look, which writes a page that shows lobes next to the results of engines, and opens this page on a
// desktop.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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
  std::vector<std::string> inputs, sources, albedos, titles;
  std::vector<double> roughnesses = {0.3}, metalnesses = {0.0};
  std::string device;
  bool stays_closed = false;
};

// Returns the value for map `i` of a list with no value, one for all maps, or one per map.
template <typename T>
T value_of(const std::vector<T>& values, std::size_t i) {
  return values.empty() ? T() : values[values.size() == 1 ? 0 : i];
}

template <typename T>
void check_count(const char* option, const std::vector<T>& values, std::size_t maps, bool one_for_all) {
  if (values.empty() || values.size() == maps || (one_for_all && values.size() == 1)) return;
  throw Error(ErrorCode::kUsage,
              fmt::format("found {} {}, expected {}, or one for each of the {} files in the same order", values.size(),
                          option, one_for_all ? "one" : "none", maps));
}

bool has_desktop() { return std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr; }

int run_look(LookOptions& o) {
  o.job.threads = apply(o.common);
  keep_freed_memory();
  check_count("--source", o.sources, o.inputs.size(), false);
  check_count("--albedo", o.albedos, o.inputs.size(), false);
  check_count("--title", o.titles, o.inputs.size(), false);
  check_count("--base-roughness", o.roughnesses, o.inputs.size(), true);
  check_count("--metalness", o.metalnesses, o.inputs.size(), true);
  for (const auto* values : {&o.roughnesses, &o.metalnesses})
    if (std::any_of(values->begin(), values->end(), [](double one) { return !std::isfinite(one); }))
      throw Error(ErrorCode::kUsage, "found nan in --base-roughness or --metalness, expected numbers");
  for (std::size_t i = 0; i < o.inputs.size(); ++i)
    o.job.maps.push_back({o.inputs[i], value_of(o.sources, i), value_of(o.albedos, i), value_of(o.titles, i),
                          value_of(o.roughnesses, i), value_of(o.metalnesses, i)});
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
      ->add_option("--source", o.sources, "the normal map that was baked, one per file (default: level 0 of the file)")
      ->allow_extra_args(false);
  command->add_option("-o,--output", o.job.output,
                      "page to write, *.html (default: the name of the input, or look.html for several)");
  command->add_option("--albedo", o.albedos, "base colours of the map's size, one per file (default: grey)")
      ->allow_extra_args(false);
  command
      ->add_option("--base-roughness", o.roughnesses,
                   "perceptual roughness, one for all files or one per file (default: 0.3)")
      ->check(CLI::Range(0.05, 1.0))
      ->allow_extra_args(false);
  command->add_option("--metalness", o.metalnesses, "metalness, one for all files or one per file (default: 0)")
      ->check(CLI::Range(0.0, 1.0))
      ->allow_extra_args(false);
  command->add_option("--title", o.titles, "name on the page, one per file (default: the file's name)")
      ->allow_extra_args(false);
  command->add_flag("--same-source", o.job.same_source, "reject a --source from which the file was not baked");
  command->add_flag("--no-open", o.stays_closed, "do not open the page");
  command->add_option("--device", o.device,
                      "use this OpenCL device: its number in `multum devices`, or part of its name");
  add_common_options(*command, o.common);
  command->footer(
      "Examples:\n"
      "  multum look bricks.ndf.exr             # writes bricks.html and opens it\n"
      "  multum look *.ndf.exr -o maps.html     # a page to choose from\n"
      "  multum look bricks.ndf.exr --source bricks_n.png -o look.html --base-roughness 0.2 --no-open\n"
      "  multum look a.ndf.exr b.ndf.exr --albedo a.png --albedo b.png --metalness 1 --metalness 0\n"
      "The page needs WebGL 2 and no network. Its reference is the map with 144 samples per pixel.\n\n"
      "Files dropped onto the page stay in the browser:\n"
      "- a baked file of lobes (compression none, rle, zips or zip; at most 2048 texels per side), with its\n"
      "  normal map if it has no level 0\n"
      "- a KTX2 file of multum export --lobes without --zstd\n"
      "- a normal map of the same size, 8 bits per channel\n"
      "- a model: NAME.glb, or NAME.gltf with its files (at most a million triangles, no required extensions)\n\n"
      "Maps have at most 2048 texels per side, and together at most 4 times 2048 x 2048.");
  command->callback([options, exit_code] { *exit_code = run_look(*options); });
}

}  // namespace multum
