// SPDX-License-Identifier: Apache-2.0
// Implements multum animation, which writes the job file for a folder of renders. Users can review and edit this file
// before the inference.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "host/fields/inference/job/animation_job.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/shown_text.h"
#include "tools/command_line/decoding_option.h"
#include "tools/multum/fields/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

struct AnimationOptions {
  std::string folder, output;
  bool json = false;
};

// Throws Error(kUsage) if a mistyped output would overwrite a render.
void check_output(const AnimationJob& job, const AnimationOptions& o) {
  std::vector<std::string> inputs = {o.folder + "/scene.json", job.geometry_file};
  for (const AnimationSample& sample : job.samples)
    for (const std::string& file : {sample.radiance, sample.geometry, sample.object_index}) inputs.push_back(file);
  check_paths_differ(inputs, {o.output});
  check_writable(o.output);
}

int run_animation(const AnimationOptions& o) {
  const AnimationJob job = job_for_folder(o.folder);
  check_output(job, o);
  write_text_file(o.output, animation_job_text(job, std::filesystem::path(o.output).parent_path().string()));
  if (o.json) {
    print_json({{"output", path_json(o.output)},
                {"samples", job.samples.size()},
                {"cameras", job.cameras.size()},
                {"objects", job.objects.size()},
                {"layers", job.layers.size()},
                {"width", job.width},
                {"height", job.height}});
    return 0;
  }
  print_shown(stdout,
              "%s: written: %zu samples (%s %d x %s %d), %zu cameras, %zu objects, %zu layers, %d x %d pixels\n",
              o.output.c_str(), job.samples.size(), job.parameters[0].name.c_str(), job.parameters[0].count,
              job.parameters[1].name.c_str(), job.parameters[1].count, job.cameras.size(), job.objects.size(),
              job.layers.size(), job.width, job.height);
  return 0;
}

}  // namespace

void add_animation_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<AnimationOptions>();
  CLI::App* animation = app.add_subcommand(
      "animation", "write the job file for a folder of ray-traced pictures (docs/reference/animation_jobs.md)");
  animation->footer("Example:\n  multum animation renders -o animation.toml");
  animation
      ->add_option("folder", options->folder, "folder with scene.json, a scene file and the pictures of each sample")
      ->required();
  animation->add_option("-o,--output", options->output, "job file to write, *.toml")->required();
  add_json_option(*animation, options->json);
  add_decoding_option(*animation);
  animation->callback([options, exit_code] { *exit_code = run_animation(*options); });
}

}  // namespace multum
