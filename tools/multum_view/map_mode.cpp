// SPDX-License-Identifier: Apache-2.0
// Draws a baked map and compares it with the reference and the baselines, for multum-view FILE, scene and animate.
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "tools/multum_view/animated_view.h"
#include "tools/multum_view/scene_plan.h"
#include "tools/multum_view/view_inputs.h"
#include "tools/multum_view/view_outputs.h"

namespace multum {

int draw_map(MapOptions options) {
  if (!options.plan.empty()) apply_scene_plan(options);
  check_map_options(options);
  if (!options.picture.shading.surface && options.comparison.reference == gl::NormalMaterial::Sampling::kInterpolated)
    options.picture.shading.surface = MapSurface::kInterpolated;
  // With several evaluation points per pixel, other texels would be read than by the pixel's filter.
  if (!options.picture.shading.evaluations && options.comparison.is_of_texels())
    options.picture.shading.evaluations = 0;
  const PictureOptions& picture = options.picture;
  ViewScenes scenes = make_scenes(picture);
  change_last_scene(options.animation, scenes);
  check_outputs(options, scenes);
  BakedMap map = read_baked_map(options.file);
  if (representation_info(map.header.representation).has_order && !picture.light.environment_mode)
    scenes.first.environment_mode = scenes.last.environment_mode = gl::EnvironmentMode::kHarmonics;
  check_options_of(options.file, picture, scenes, !options.comparison.pictures.empty(), map.header);
  if (map.header.has_roughness) scenes.first.brdf.exponent = scenes.last.brdf.exponent = kRoughnessExponent;
  warn_of_sources(options, map.header);
  if (options.stored_only) keep_stored_levels(map);
  const gl::MeshData mesh_data = make_mesh(picture, scenes);
  const gl::NormalImage source =
      needs_source(options, map.header) ? read_source(options, scenes, map) : gl::NormalImage{};
  read_environments(options, scenes);
  read_brdf_roughness(options, map.header, scenes);
  const std::unique_ptr<gl::HeadlessContext> context = gl::make_headless_context(picture.context);
  log_info(context->description());
  warn_of_wrong_anisotropy(options, map.header, context->description());
  if (const std::string note = environment_note(options, map.header); !note.empty()) log_info(note);
  const gl::Mesh mesh(context->functions(), mesh_data);
  PictureDrawer drawer(options, scenes.basis, context->functions(), mesh, map, source);
  const nlohmann::json rows =
      options.animation.folder.empty()
          ? draw_views(picture, scenes.first, [&](const gl::RenderScene& scene) { return drawer.draw(scene); })
          : draw_animation(options, scenes, drawer);
  if (!options.shaders.empty()) write_shaders(options.shaders, drawer.variants());
  if (!picture.output.report.empty())
    write_report(picture, scenes.first, {*context, options.comparison, map.header.has_roughness}, rows);
  return 0;
}

}  // namespace multum
