// SPDX-License-Identifier: Apache-2.0
// multum look: a page that shows lobes beside what engines do, opened where there is a desktop.
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
    throw Error(ErrorCode::kUsage, fmt::format("found {} --source, expected one for each of {} files, in their order, "
                                               "or none",
                                               o.sources.size(), o.inputs.size()));
  for (std::size_t i = 0; i < o.inputs.size(); ++i)
    o.job.maps.push_back({o.inputs[i], o.sources.empty() ? "" : o.sources[i]});
  if (o.job.output.empty()) {
    const std::string name = std::filesystem::path(o.inputs[0]).filename().string();
    o.job.output = o.inputs.size() > 1 ? "look.html" : name.substr(0, name.find('.')) + ".html";
  }
  if (!o.job.output.ends_with(".html"))
    throw Error(ErrorCode::kUsage, o.job.output + ": is no name of a page, expected NAME.html");
  Device device = Device::when_needed({o.device});
  const auto progress = make_progress(o.common);
  write_look_page(o.job, device, progress.get());
  const std::string path = std::filesystem::absolute(o.job.output).string();
  const bool opens = has_desktop() && !o.stays_closed;
  if (!o.common.quiet)
    print_shown(stdout, "%s: written: %.1f MB; %s\n", path.c_str(),
                static_cast<double>(std::filesystem::file_size(o.job.output)) / 1e6,
                opens ? "opening it" : "open it in a browser with WebGL 2");
  if (opens && run_child({"xdg-open", path}).exit_code != 0)
    throw Error(ErrorCode::kEnvironment, path + ": is written, but xdg-open could not open it; open it in a browser");
  return 0;
}

}  // namespace

void add_look_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<LookOptions>();
  LookOptions& o = *options;
  CLI::App* command = app.add_subcommand(
      "look", "a page that shows lobes in a browser beside averaged normals, engines' rules and the one-lobe export");
  command->add_option("inputs", o.inputs, "baked files of lobes, *.ndf.exr; the page has a list of them")->required();
  command
      ->add_option("--source", o.sources,
                   "normal map that FILE was baked from, once for each FILE (default: level 0 of FILE)")
      ->allow_extra_args(false);
  command->add_option("-o,--output", o.job.output,
                      "page to write, *.html (default: the input's name, of several look.html, here)");
  command
      ->add_option("--base-roughness", o.job.base_roughness, "perceptual roughness of the surface, the same everywhere")
      ->check(CLI::Range(0.05, 1.0))
      ->capture_default_str();
  command->add_flag("--same-source", o.job.same_source, "refuse a map that is not the file that was baked");
  command->add_flag("--no-open", o.stays_closed, "only write the page");
  command->add_option("--device", o.device, "OpenCL device, part of its name or index (multum devices)");
  add_common_options(*command, o.common);
  command->footer(
      "Examples:\n"
      "  multum look bricks.ndf.exr                                             # bricks.html, opened in the browser\n"
      "  multum look *.ndf.exr -o maps.html                                     # several, to choose from\n"
      "  multum look bricks.ndf.exr --source bricks_n.png -o look.html --base-roughness 0.2 --no-open");
  command->callback([options, exit_code] { *exit_code = run_look(*options); });
}

}  // namespace multum
