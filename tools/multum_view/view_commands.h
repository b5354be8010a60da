// SPDX-License-Identifier: Apache-2.0
// Lists the subcommands of multum-view, with one row per subcommand, and the options that they set.
#pragma once

#include <vector>

#include "tools/multum_view/modes.h"

namespace multum {

struct CommandOptions {
  MapOptions map;  // used without a subcommand, and by scene and animate
  SampleOptions sample;
  PlayOptions play;
  ProbeOptions probe;
  ThumbnailOptions thumbnails;
  PyramidOptions pyramid;
  LodOptions lod;
  ModelOptions model;
  EachOptions each;
};

struct ViewCommand {
  const char* name;
  const char* description;
  const char* examples;
  void (*add)(CLI::App&, CommandOptions&);
  int (*run)(const CommandOptions&);
};

/// Returns the subcommands for fields, which are sample, play and probe. In a build without fields (MULTUM_FIELDS),
/// returns none.
std::vector<ViewCommand> field_commands();

}  // namespace multum
