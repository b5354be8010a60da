// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/nearest_name.h"
#include "host/foundation/base/shown_text.h"
#include "tools/command_line/absent_commands.h"
#include "tools/command_line/before_command.h"
#include "tools/command_line/help_files.h"
#include "tools/command_line/usage_error.h"
#include "tools/multum_view/driver_faults.h"
#include "tools/multum_view/view_commands.h"

namespace multum {
namespace {

void add_object_option(CLI::App& app, MapOptions& options) {
  app.add_option("--object", options.object, "object of the scene to draw (default: the only object)");
}

void add_scene_options(CLI::App& app, CommandOptions& o) {
  app.add_option("plan", o.map.plan, "plan.json that `multum bake scene.toml` wrote; options replace its settings")
      ->required();
  add_object_option(app, o.map);
  add_picture_option(app, o.map.picture.output)->required();
  add_pictures_option(app, o.map.picture.output);
  add_alone_option(app, o.map.picture.output);
  add_distance_option(app, o.map.picture.camera);
  add_map_options(app, o.map);
}

void add_animate_options(CLI::App& app, CommandOptions& o) {
  CLI::Option* const file = app.add_option("file", o.map.file, "baked map, *.ndf.exr");
  app.add_option("--scene", o.map.plan, "plan.json of a scene, instead of a baked map")->excludes(file);
  add_object_option(app, o.map);
  app.add_option("-o,--output", o.map.animation.folder, "folder for the frames: frame_0000.png and so on")->required();
  add_animation_options(app, o.map.animation);
  add_map_options(app, o.map);
}

int run_animate(const CommandOptions& o) {
  if (o.map.file.empty() && o.map.plan.empty())
    throw Error(ErrorCode::kUsage, "animate: found no file and no --scene, expected one of them");
  return draw_map(o.map);
}

const ViewCommand kOwnCommands[] = {
    {"scene", "Draw an object of a scene that `multum bake scene.toml` baked",
     "  multum-view scene out/plan.json --object wall -o wall.png", add_scene_options,
     [](const CommandOptions& o) { return draw_map(o.map); }},
    {"animate",
     "Draw frames in even steps between two cameras, lights or BRDFs. Exponents and roughnesses change by equal "
     "factors",
     "  multum-view animate bricks.ndf.exr --brdf ggx:0.5 --to-brdf ggx:0.1 -o frames/ --frames 60\n\n"
     "In the report, environment_processor_ms contains two processor times of a frame, made and set. made is the time\n"
     "to compute the maps of the light. Frames between the first and the last mix the maps of these two frames. set\n"
     "is the time for uploads and, with --environment-mode sh, for harmonics over the half vectors of the frame.",
     add_animate_options, run_animate},
    {"pyramid", "Draw a surface with colours from a pyramid, using several lookup methods",
     "  multum-view pyramid bricks.exr --lookup reference,nearest,level,driver -o sheet.png\n"
     "  multum-view pyramid lights.exr --mesh ball.obj --lookup reference,level --shifts 8 -o sheet.png",
     [](CLI::App& app, CommandOptions& o) { add_pyramid_options(app, o.pyramid); },
     [](const CommandOptions& o) { return draw_pyramid(o.pyramid); }},
    {"lod", "Draw one level of a pyramid of heights or positions as a mesh",
     "  multum-view lod terrain.exr --level 2.5 -o view.png",
     [](CLI::App& app, CommandOptions& o) { add_lod_options(app, o.lod); },
     [](const CommandOptions& o) { return draw_lod(o.lod); }},
    {"model", "Draw a glTF model with its materials and their baked maps",
     "  multum-view model ship.gltf --material hull=maps/1_hull.ndf.exr -o ship.png",
     [](CLI::App& app, CommandOptions& o) { add_model_options(app, o.model); },
     [](const CommandOptions& o) { return draw_model(o.model); }},
    {"thumbnails", "Draw small pictures of the input and result of a job, for the page of the service",
     "  multum-view thumbnails bricks.ndf.exr -o pictures/ --source bricks_normal.png\n\n"
     "The command writes render.png. With --source, if the map has not changed since the bake, it also writes\n"
     "input.png and error.png, which shows four times the error. For a folder written by `multum infer`, it writes\n"
     "only render.png.",
     [](CLI::App& app, CommandOptions& o) { add_thumbnail_options(app, o.thumbnails); },
     [](const CommandOptions& o) { return draw_thumbnails(o.thumbnails); }},
    {"each", "Run several command lines in one process, so that GL is loaded only once",
     "  multum-view each views.json\n"
     "\n"
     "views.json: [[\"bricks.ndf.exr\", \"-o\", \"bricks.png\"], [\"wall.ndf.exr\", \"-o\", \"wall.png\"]]\n"
     "The first command line that fails ends the run with its exit code.",
     [](CLI::App& app, CommandOptions& o) { add_each_options(app, o.each); },
     [](const CommandOptions& o) { return run_each(o.each); }}};

const std::vector<ViewCommand>& view_commands() {
  static const std::vector<ViewCommand> commands = [] {
    std::vector<ViewCommand> all(std::begin(kOwnCommands), std::end(kOwnCommands));
    const std::vector<ViewCommand> more = field_commands();
    all.insert(all.begin() + 2, more.begin(), more.end());  // inserted after scene and animate
    return all;
  }();
  return commands;
}

const char* const kDescription = "Draw a baked map to a file, in software or on a GPU.";

const char* const kExamples =
    "Examples:\n"
    "  multum-view bricks.ndf.exr -o frame.png\n"
    "  multum-view bricks.ndf.exr --source bricks_normal.png --compare reference,mip,toksvig,lean-jacobian -o "
    "sheet.png\n"
    "  multum-view animate bricks.ndf.exr --brdf ggx:0.5 --to-brdf ggx:0.1 -o frames/ --frames 60\n\n"
    "--compare: mip, toksvig, lean and lean-jacobian use averaged normals and the filter of the baked map. points,\n"
    "toksvig-points and so on shade averaged normals at several points per pixel. The number of points is the number "
    "of\n"
    "evaluations of the baked map. On a mesh, all methods add the variance of the mesh normals within a pixel. Under\n"
    "--environment, lean is the same as toksvig. For a file with roughness, the pictures of points use unit normals\n"
    "and a roughness map whose levels average perceptual roughness, as in engines.\n\n"
    "--evaluations: where the normals under a pixel are similar, each evaluation shades one lobe at its own point.\n"
    "Elsewhere, evaluations shade several lobes at fewer points. If a texel has more lobes than evaluations, the\n"
    "most similar lobes are merged. On a mesh, lobes are read at 2 x 2 places of the pixel and rotated by the\n"
    "surface frame at each place. The default is 0 with --shade-taps, --shade-first, --formula paper and\n"
    "--reference-of texels, and for one lobe, planar Gaussians, moments and harmonics.\n\n"
    "The options from --bumpformat to --repair-max apply to --source. Their defaults are the settings of the bake.";

void add_commands(CLI::App& app, CommandOptions& options) {
  app.set_version_flag("--version", std::string("multum-view ") + MULTUM_VERSION);
  app.require_subcommand(0, 1);
  app.add_option("file", options.map.file, "baked map, *.ndf.exr, or lobe texture of multum export --lobes, *.ktx2");
  add_picture_option(app, options.map.picture.output);
  add_pictures_option(app, options.map.picture.output);
  add_alone_option(app, options.map.picture.output);
  add_distance_option(app, options.map.picture.camera);
  add_map_options(app, options.map);
  for (const ViewCommand& command : view_commands()) {
    CLI::App* const added = app.add_subcommand(command.name, command.description);
    added->group("Commands");
    added->footer(std::string("Examples:\n") + command.examples);
    command.add(*added, options);
  }
  if (field_commands().empty()) add_absent_commands(app, {"sample", "play", "probe"}, "fields", "MULTUM_FIELDS");
}

struct HelpOptions {
  std::string shell, folder;
  bool markdown = false;
};

// Adds hidden commands that multum completion and multum man call.
void add_help_commands(CLI::App& app, HelpOptions& o) {
  CLI::App* const completion = app.add_subcommand("completion", "")->group("");
  completion->add_option("shell", o.shell)->required()->check(CLI::IsMember(kShells));
  CLI::App* const man = app.add_subcommand("man", "")->group("");
  man->add_option("-o,--output", o.folder);
  man->add_flag("--markdown", o.markdown);
}

void run_help_command(const CLI::App& app, const std::string& command, const HelpOptions& o) {
  if (command == "completion") write_shown(stdout, completion_of(app, o.shell));
  else if (o.markdown) write_shown(stdout, command_page_of(app));
  else write_man_pages(app, o.folder);
}

/// Returns the message about a misspelt subcommand, or an empty string if there is a file with this name.
std::string misspelt_command(const std::string& word) {
  std::error_code ignored;
  if (word.empty() || word.find_first_of("./") != std::string::npos || std::filesystem::exists(word, ignored))
    return "";
  std::vector<std::string> names;
  for (const ViewCommand& command : view_commands()) names.emplace_back(command.name);
  const std::string nearest = nearest_name(word, names);
  if (nearest.empty()) return "";
  return fmt::format("unknown subcommand '{}' (did you mean '{}'?), expected one of: {}", word, nearest,
                     fmt::join(names, ", "));
}

/// Returns the message about an option that only subcommands have, or an empty string.
std::string option_of_subcommands(const CLI::App& app) {
  for (const std::string& word : app.remaining(true)) {
    const std::string name = word.substr(0, word.find('='));
    std::vector<std::string> owners;
    for (const CLI::App* const command : app.get_subcommands([](const CLI::App*) { return true; }))
      if (name.starts_with("--") && command->get_option_no_throw(name) != nullptr)
        owners.push_back("'" + app.get_name() + " " + command->get_name() + "'");
    if (!owners.empty())
      return fmt::format("unknown option '{}' here; it is an option of {}", name, fmt::join(owners, " and "));
  }
  return "";
}

std::string view_usage_error(const CLI::App* app, const CLI::Error& error) {
  const std::vector<CLI::App*> chosen = app->get_subcommands();
  const std::string program = app->get_name() + (chosen.empty() ? "" : " " + chosen.front()->get_name());
  std::string text = chosen.empty() ? option_of_subcommands(*app) : "";
  if (text.empty()) text = parse_error_text(*app, error);
  return fmt::format("{}: {}\nSee '{} --help'.\n", program, text, program);
}

/// Returns the subcommand to run, or an empty string to draw a baked map. Throws Error(kUsage) for options before a
/// subcommand, because they would have no effect.
std::string chosen_command(const CLI::App& app, const CommandOptions& options) {
  if (app.get_subcommands().empty()) {
    if (options.map.file.empty()) throw CLI::RequiredError("file");
    if (options.map.picture.output.path.empty()) throw CLI::RequiredError("--output");
    return "";
  }
  const std::string command = app.get_subcommands().front()->get_name();
  for (const CLI::Option* const option : app.get_options())
    if (option->count() > 0)
      throw Error(
          ErrorCode::kUsage,
          fmt::format("found {} before '{}', expected the options of a subcommand after it",
                      option->get_positional() ? options.map.file : "--" + option->get_lnames().front(), command));
  return command;
}

}  // namespace

int run_view_command(int argc, char** argv) {
  CommandOptions options;
  HelpOptions help;
  CLI::App app(kDescription, "multum-view");
  app.footer(kExamples);
  app.failure_message(view_usage_error);
  add_commands(app, options);
  add_help_commands(app, help);
  prepare_commands(app);
  const NewFolders new_folders;
  std::string chosen;
  try {
    app.parse(argc, argv);
    chosen = chosen_command(app, options);
  } catch (const CLI::ParseError& error) {
    const std::string message = app.get_subcommands().empty() ? misspelt_command(options.map.file) : "";
    if (error.get_exit_code() != 0 && !message.empty()) throw Error(ErrorCode::kUsage, message);
    return print_parse_error(app, error);
  }
  if (chosen.empty()) {
    if (const std::string message = misspelt_command(options.map.file); !message.empty())
      throw Error(ErrorCode::kUsage, message);
  }
  explain_driver_faults();
  int code = 0;
  if (chosen == "completion" || chosen == "man") run_help_command(app, chosen, help);
  if (chosen.empty()) code = draw_map(options.map);
  for (const ViewCommand& command : view_commands())
    if (chosen == command.name) code = command.run(options);
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw Error(ErrorCode::kEnvironment, "standard output cannot be written");
  return code;
}

}  // namespace multum
