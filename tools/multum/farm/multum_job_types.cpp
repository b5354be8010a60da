// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/farm/multum_job_types.h"

#include "host/bakes/scene/scene_file.h"
#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/export_parameters.h"

namespace multum {
namespace {

constexpr std::int64_t kMiB = 1 << 20;
constexpr std::size_t kLooksMax = 16;  // maximum number of stored pages; the page of the largest map has a size of 37
                                       // MB

constexpr const char* kNoScene = "a map; for a scene, submit a job of type scene";

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
          // Pictures are drawn in software, because bakes may use the GPU at the same time.
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
                     .first_map_is_for = "the page shows the lobes next to the map that was baked",
                     .folder_ending = "-look",
                     .kept_max = kLooksMax,
                     .shown = {{"look.html", "Look at its lobes", "Save a page that shows its lobes"}},
                     .only_for = {{"ndf", "vmf"}}}},
          .no_other_view = "only packed fields have a player",
          .estimate_command = "plan"};
}

JobType scene_type() {
  return {.name = "scene",
          .summary = "bake only what a scene shows of its maps",
          .command = "bake",
          .input = "scene",
          .output_is_folder = true,
          .files_of_input = scene_files,
          .memory_bytes = 1024 * kMiB,
          .table = &scene_parameters()};
}

JobType export_type() {
  return {.name = "export",
          .summary = "write a normal map as textures for engines, with fitted mips",
          .command = "export",
          .input = "input",
          .output_is_folder = true,
          .input_is_one_map = true,
          // Untrusted images are decoded by a child process without privileges. A baked file would be decoded by the
          // worker itself.
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
