// SPDX-License-Identifier: Apache-2.0
// Implements multum player, which publishes a packed field together with a player for browsers.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/fields/player/player_output.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/sandbox/path_roots.h"
#include "tools/multum/fields/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

struct PlayerOptions {
  CommonOptions common;
  std::string field, output;
  std::vector<std::string> roots;
};

int run_player(const PlayerOptions& o) {
  apply(o.common);
  const bool is_page = std::filesystem::path(o.output).extension() == ".html";
  PlayerOutput output{is_page ? "" : o.output, is_page ? o.output : ""};
  if (!o.roots.empty())
    output.check_geometry = [roots = PathRoots(o.roots)](const std::string& path) { roots.input(path); };
  check_paths_differ({o.field}, {o.output});
  check_player_output(output);
  write_player(o.field, output);
  if (o.common.json) print_json({{"output", path_json(o.output)}});
  if (prints_text(o.common)) print_shown(stdout, "%s: written: the player\n", o.output.c_str());
  return 0;
}

}  // namespace

void add_player_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<PlayerOptions>();
  CLI::App* player = app.add_subcommand(
      "player", "publish a packed field with its player for browsers (docs/reference/animation_jobs.md)");
  player->footer("Example:\n  multum player field.mpt -o field.html");
  player->add_option("field", options->field, "packed field, *.mpt")->required();
  player
      ->add_option("-o,--output", options->output,
                   "output: a folder that any static web server can serve, or a single *.html page")
      ->required();
  // The service passes its roots, because files that a field names may be opened only if they are below these roots.
  player->add_option("--root", options->roots)->allow_extra_args(false)->group("");
  add_common_options(*player, options->common);
  player->callback([options, exit_code] { *exit_code = run_player(*options); });
}

}  // namespace multum
