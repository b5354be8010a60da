// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/farm/multum_job_types.h"

#include "host/bakes/scene/scene_file.h"
#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/export_parameters.h"

namespace multum {
namespace {

constexpr std::int64_t kMiB = 1 << 20;
constexpr std::size_t kLooksMax = 16;  // pages that are kept; one of the largest map that they show is 37 MB

constexpr const char* kNoScene = "a map; a scene is baked by a job of type scene";

JobType bake_type() {
  return {.name = "bake",
          .summary = "bake a normal map or height field into a mipmap of normal distributions",
          .command = "bake",
          .input = "input",
          .input_is_one_map = true,
          .refused_inputs = {{".toml", kNoScene}},
          .output_extension = ".ndf.exr",
          .memory_bytes = 1024 * kMiB,
          .table = &bake_parameters(),
          // Not the GPU, which bakes may be using.
          .views = {{.files = {"render.png", "input.png", "error.png"},
                     .program = "multum-view",
                     .words = {"thumbnails", "--context=osmesa"},
                     .writes_folder = true,
                     .maps = {{"input", "--source"}, {"albedo", "--albedo"}},
                     .shown = {{"input.png", "input"},
                               {"render.png", "baked, rendered"},
                               {"error.png", "error, four times"}}},
                    {.files = {"look.html"},
                     .words = {"look", "-q", "--no-open", "--same-source"},
                     .maps = {{"input", "--source"}},
                     .first_map_is_for = "the page shows the lobes beside the map that was baked",
                     .folder_ending = "-look",
                     .kept_max = kLooksMax,
                     .shown = {{"look.html", "Look at its lobes", "Save a page of its lobes"}},
                     .only_for = {{"ndf", "vmf"}}}},
          .no_other_view = "packed fields alone have a player",
          .estimate_command = "plan"};
}

JobType scene_type() {
  return {.name = "scene",
          .summary = "bake the maps of a scene, each as the scene needs it",
          .command = "bake",
          .input = "scene",
          .output_is_folder = true,
          .files_of_input = scene_files,
          .memory_bytes = 1024 * kMiB,
          .table = &scene_parameters()};
}

JobType export_type() {
  return {.name = "export",
          .summary = "fit a normal map's mips as a material that engines load",
          .command = "export",
          .input = "input",
          .output_is_folder = true,
          .input_is_one_map = true,
          // Images of strangers are decoded by a child without rights, baked files by the worker itself.
          .refused_inputs = {{".ndf.exr", "a map, not a baked file"}, {".toml", kNoScene}},
          .refused_extensions = {".ktx2", ".dds", ".png", ".exr", ".glb", ".gltf"},
          .memory_bytes = 1024 * kMiB,
          .table = &export_parameters()};
}

}  // namespace

std::vector<JobType> multum_job_types() {
  std::vector<JobType> types = {bake_type(), scene_type()};
  for (const JobType& type : field_job_types()) types.push_back(type);
  types.push_back(export_type());
  return types;
}

}  // namespace multum
