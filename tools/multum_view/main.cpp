// SPDX-License-Identifier: Apache-2.0
// multum-view: reads a baked map and a mesh, renders them with runtime_gl, compares them with the truth and with what
// users have today, and writes pictures and errors.
#include <algorithm>
#include <cstdio>

#include "host/base/error.h"
#include "host/base/log.h"
#include "tools/multum_view/animated_view.h"
#include "tools/multum_view/modes.h"
#include "tools/multum_view/scene_arguments.h"
#include "tools/multum_view/view_drawing.h"
#include "tools/multum_view/view_inputs.h"
#include "tools/multum_view/view_outputs.h"

namespace multum {
namespace {

bool has_option(int argc, char** argv, std::string_view name) {
  return std::any_of(argv + 1, argv + argc, [&](std::string_view argument) {
    return argument == name || argument.substr(0, name.size() + 1) == std::string(name) + "=";
  });
}

int run(int argc, char** argv) {
  if (has_option(argc, argv, "--probe")) return run_probe(argc, argv);
  if (has_option(argc, argv, "--thumbnails")) return run_thumbnails(argc, argv);
  if (has_option(argc, argv, "--sample")) return run_inferred(argc, argv);
  int exit_code = 0;
  const std::vector<std::string> arguments = with_scene({argv, argv + argc});
  std::vector<char*> pointers;
  for (const std::string& argument : arguments) pointers.push_back(const_cast<char*>(argument.c_str()));
  std::optional<ViewOptions> options =
      parse_view_options(static_cast<int>(pointers.size()), pointers.data(), &exit_code);
  if (!options.has_value()) return exit_code;
  check_outputs(*options);
  if (!options->mip.empty() || !options->reflectance.empty()) return run_pyramid(*options);
  if (!options->lod.empty()) return run_lod(*options);
  if (!options->materials.empty()) return run_model(*options);
  BakedMap map = read_baked_map(options->input);
  check_options_of(*options, map.header);
  options->brdf_is_in_map = map.header.has_roughness;
  if (map.header.has_roughness) options->scene.brdf.exponent = options->last_scene.brdf.exponent = kRoughnessExponent;
  warn_of_sources(*options, map.header);
  if (options->stored_only) keep_stored_levels(map);
  const gl::MeshData mesh_data = make_mesh(*options);
  const gl::NormalImage source = needs_source(*options, map.header) ? read_source(*options, map) : gl::NormalImage{};
  options->scene.environment = options->last_scene.environment = read_environment(*options);
  const std::unique_ptr<gl::HeadlessContext> context = gl::make_headless_context(options->context);
  log_info(context->description());
  warn_of_wrong_anisotropy(*options, map.header, context->description());
  if (const std::string note = environment_note(*options, map.header); !note.empty()) log_info(note);
  const gl::Mesh mesh(context->functions(), mesh_data);
  PictureDrawer drawer(*options, context->functions(), mesh, map, source);
  nlohmann::json rows;
  if (options->frames_folder.empty()) {
    rows = draw_views(*options, [&](const ViewOptions& view) { return drawer.draw(view.scene); });
  } else {
    rows = draw_animation(*options, drawer);
  }
  if (!options->shaders.empty()) write_shaders(*options, drawer.variants());
  if (!options->report.empty()) write_report(*options, context->description(), rows);
  if (std::fflush(stdout) != 0) throw Error(ErrorCode::kEnvironment, "standard output cannot be written");
  return 0;
}

}  // namespace
}  // namespace multum

int main(int argc, char** argv) { return multum::run_guarded("multum-view", multum::run, argc, argv); }
