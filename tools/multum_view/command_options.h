// SPDX-License-Identifier: Apache-2.0
// Everything that a command line of multum-view may say, and the options that stood for subcommands before there were
// any.
#pragma once

#include "tools/multum_view/modes.h"

namespace multum {

struct CommandOptions {
  MapOptions map;  // of no subcommand, scene and animate
  SampleOptions sample;
  PlayOptions play;
  ProbeOptions probe;
  ThumbnailOptions thumbnails;
  PyramidOptions pyramid;
  LodOptions lod;
  ModelOptions model;
  EachOptions each;
  std::vector<std::string> outputs;  // -o without a subcommand
};

/// --object, of scene and animate.
void add_object_option(CLI::App& app, MapOptions& options);

/// Adds the options that stand for subcommands, and those that go with them alone; --help does not show them.
void add_alias_options(CLI::App& app, CommandOptions& options);

/// Returns the subcommand that the given options stand for, with its options where it has them; empty: none. Throws
/// Error(kUsage) for options of several subcommands, or that the one does not take.
std::string apply_aliases(const CLI::App& app, CommandOptions& options);

/// "--size".
std::string long_name(const CLI::Option& option);

}  // namespace multum
