// SPDX-License-Identifier: Apache-2.0
// The spellings of multum-view from before it had subcommands: an option each, on the program itself. What the program
// has parsed then goes to where the subcommand has it, so that both spellings run the same code.
#include <fmt/format.h>

#include <algorithm>

#include "host/foundation/base/error.h"
#include "tools/multum_view/command_options.h"

namespace multum {
namespace {

struct Alias {
  const char* option;
  const char* command;
  bool takes_file;                // the program's own positional is the subcommand's
  const char* also_takes;         // an option that the subcommand spells otherwise; empty: none
  void (*move)(CommandOptions&);  // from where the program has its options to where the subcommand has them
};

std::string only_output(const CommandOptions& options) {
  if (options.outputs.empty()) throw CLI::RequiredError("--output");
  if (options.outputs.size() > 1)
    throw Error(ErrorCode::kUsage, fmt::format("--output: found {}, expected one", options.outputs.size()));
  return options.outputs.front();
}

void move_probe(CommandOptions& o) { o.probe.context = o.map.picture.context; }

void move_thumbnails(CommandOptions& o) {
  if (o.map.file.empty()) throw CLI::RequiredError("result");
  o.thumbnails.result = o.map.file;
  o.thumbnails.source = o.map.source.normals;
  o.thumbnails.albedo = o.map.source.albedo;
  o.thumbnails.context = o.map.picture.context;
}

void move_sample(CommandOptions& o) {
  if (o.map.file.empty()) throw CLI::RequiredError("folder");
  if (o.outputs.empty()) throw CLI::RequiredError("--output");
  o.sample.folder = o.map.file;
  o.sample.outputs = o.outputs;
  o.sample.context = o.map.picture.context;
  o.sample.exposure = o.map.picture.output.exposure;
}

void move_map(CommandOptions& o) { o.map.picture.output.path = only_output(o); }

void move_pyramid(CommandOptions& o) {
  move_map(o);
  o.pyramid.surface = o.map.picture.surface;
  o.pyramid.camera = o.map.picture.camera;
  o.pyramid.output = o.map.picture.output;
  if (o.map.comparison.sampling.sample_count > 0) o.pyramid.samples = o.map.comparison.sampling.sample_count;
  o.pyramid.level_bias = o.map.picture.shading.level_bias;
  o.pyramid.anisotropy = o.map.picture.shading.anisotropy;
  o.pyramid.context = o.map.picture.context;
}

void move_mip(CommandOptions& o) {
  o.pyramid.expected = PyramidKind::kColour;
  move_pyramid(o);
}

void move_reflectance(CommandOptions& o) {
  o.pyramid.expected = PyramidKind::kReflectance;
  move_pyramid(o);
}

void move_lod(CommandOptions& o) {
  move_map(o);
  o.lod.picture = o.map.picture;
}

void move_model(CommandOptions& o) {
  move_map(o);
  if (o.map.picture.surface.mesh.empty()) throw Error(ErrorCode::kUsage, "--material is for a model, expected --mesh");
  o.model.picture = o.map.picture;
}

void move_nothing(CommandOptions&) {}

// The first one that is given says which subcommand runs; --scene goes with --animate too.
constexpr Alias kAliases[] = {{"--probe", "probe", false, "", move_probe},
                              {"--thumbnails", "thumbnails", true, "", move_thumbnails},
                              {"--sample", "sample", true, "", move_sample},
                              {"--mip", "pyramid", false, "", move_mip},
                              {"--reflectance", "pyramid", false, "", move_reflectance},
                              {"--lod", "lod", false, "", move_lod},
                              {"--material", "model", false, "--mesh", move_model},
                              {"--animate", "animate", true, "", move_nothing},
                              {"--scene", "scene", false, "", move_map}};

bool is_given(const CLI::App& app, const std::string& option) { return app.get_option(option)->count() > 0; }

bool is_alias(const std::string& name) {
  return std::any_of(std::begin(kAliases), std::end(kAliases),
                     [&](const Alias& alias) { return alias.option == name; });
}

/// Refuses what the subcommand behind an alias does not take.
void check_alias(const CLI::App& app, const Alias& alias, const std::string& file) {
  const std::string subject = is_given(app, "--scene") ? "--scene" : alias.option;
  if (!file.empty() && (!alias.takes_file || subject == "--scene"))
    throw Error(ErrorCode::kUsage,
                fmt::format("found {} beside {}: not expected, expected one of them", file, subject));
  const CLI::App* const command = app.get_subcommand(alias.command);
  for (const CLI::Option* const option : app.get_options()) {
    const std::string name = long_name(*option);
    if (option->count() == 0 || option->get_positional() || name == alias.option || name == alias.also_takes) continue;
    if (name == "--output" && alias.option == std::string("--animate"))
      throw Error(ErrorCode::kUsage, "--animate writes FOLDER/frame_0000.png and so on: leave out -o and --pictures");
    if (command->get_option_no_throw(name) != nullptr) continue;
    if (is_alias(name))
      throw Error(ErrorCode::kUsage, fmt::format("found {} and {}, expected one of them", alias.option, name));
    throw Error(ErrorCode::kUsage, fmt::format("found {} beside {}, expected options of 'multum-view {}', which its "
                                               "--help lists",
                                               name, alias.option, alias.command));
  }
}

/// Refuses options that only subcommands have.
void check_plain(const CLI::App& app) {
  for (const CLI::Option* const option : app.get_options()) {
    if (option->count() == 0 || !option->get_group().empty()) continue;
    const std::string name = long_name(*option);
    std::string commands;
    for (const CLI::App* const command : app.get_subcommands([](const CLI::App*) { return true; }))
      if (command->get_option_no_throw(name) != nullptr)
        commands += (commands.empty() ? "" : " or ") + command->get_name();
    throw Error(ErrorCode::kUsage, fmt::format("{} is for 'multum-view {}', found no subcommand", name, commands));
  }
}

}  // namespace

std::string long_name(const CLI::Option& option) {
  return option.get_lnames().empty() ? option.get_name() : "--" + option.get_lnames().front();
}

void add_object_option(CLI::App& app, MapOptions& options) {
  app.add_option("--object", options.object, "name of the scene's object (default: its only one)");
}

void add_alias_options(CLI::App& app, CommandOptions& o) {
  app.option_defaults()->group("");
  app.add_option("--scene", o.map.plan);
  add_object_option(app, o.map);
  app.add_option("--animate", o.map.animation.folder);
  add_animation_options(app, o.map.animation);
  app.add_option("--sample", o.sample.samples)->allow_extra_args(false);
  app.add_option("--probe", o.probe.request);
  add_measuring_options(app, o.probe);
  app.add_option("--thumbnails", o.thumbnails.folder);
  app.add_option("--mip", o.pyramid.file);
  app.add_option("--reflectance", o.pyramid.file);
  add_lookup_options(app, o.pyramid);
  app.add_option("--lod", o.lod.file);
  add_level_option(app, o.lod.detail);
  add_material_map_option(app, o.model);
  app.option_defaults()->group("Options");
}

std::string apply_aliases(const CLI::App& app, CommandOptions& options) {
  for (const Alias& alias : kAliases) {
    if (!is_given(app, alias.option)) continue;
    check_alias(app, alias, options.map.file);
    alias.move(options);
    return alias.command;
  }
  check_plain(app);
  if (options.map.file.empty()) throw CLI::RequiredError("file");
  move_map(options);
  return "";
}

}  // namespace multum
