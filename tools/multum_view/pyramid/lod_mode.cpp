// SPDX-License-Identifier: Apache-2.0
// Implements multum-view lod, which draws a pyramid of heights or positions as a mesh at one level of detail (Williams
// 1983, section 5).
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/formats/asset/pyramid/pyramid_surface.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/shown_text.h"
#include "runtime_gl/materials/normal_material.h"
#include "tools/multum_view/modes.h"
#include "tools/multum_view/view_inputs.h"
#include "tools/multum_view/view_outputs.h"
#include "tools/multum_view/write_image.h"

namespace multum {

void add_lod_options(CLI::App& app, LodOptions& options) {
  PictureOptions& picture = options.picture;
  app.add_option("file", options.file, "height or position pyramid written by `multum lod`")->required();
  add_picture_option(app, picture.output)->required();
  add_detail_options(app, options.detail);
  app.add_option(
         "--patches", options.patch_steps,
         "draw bicubic B-spline patches with this many cells per side, whose control points are the points of the "
         "level")
      ->check(CLI::Range(1, kPatchStepsMax));
  add_camera_options(app, picture.camera);
  add_light_options(app, picture.light);
  add_material_options(app, picture.material);
  add_output_options(app, picture.output);
  add_context_option(app, picture.context);
}

int draw_lod(const LodOptions& options) {
  const PictureOptions& picture = options.picture;
  check_picture_path(picture.output.path);
  check_paths_differ({options.file}, {picture.output.path, picture.output.report});
  ViewScenes scenes = make_scenes(picture);
  const Pyramid pyramid = read_surface_pyramid(options.file);
  // The camera does not depend on the level. A given camera is used unchanged, and the default camera shows the whole
  // finest level.
  frame_mesh(to_triangle_mesh(surface_at_level(pyramid, 0.0)), options.file, picture.output, scenes);
  const double level = detail_level(options.detail, pyramid, scenes.first.camera, picture.output.height());
  const PyramidSurface surface =
      options.patch_steps ? patches_at_level(pyramid, level, *options.patch_steps) : surface_at_level(pyramid, level);
  const TriangleMesh mesh = to_triangle_mesh(surface);
  const std::unique_ptr<gl::HeadlessContext> context = gl::make_headless_context(picture.context);
  log_info(context->description());
  const gl::NormalMaterial flat(context->functions(), {1, 1, {{0.0f, 0.0f, 1.0f}}, {}},
                                gl::NormalMaterial::Sampling::kNearest, 1.0f);
  gl::Renderer renderer(context->functions(), picture.output.width(), picture.output.height());
  const gl::Mesh drawn(context->functions(), to_mesh_data(mesh));
  const std::vector<NamedPicture> pictures = {{"lod", renderer.draw(drawn, flat, scenes.first)}};
  const std::size_t triangles = surface.indices.size() / 3;
  write_shown(stdout, fmt::format("level {:g}: {} x {} points, {} triangles\n", level, surface.columns, surface.rows,
                                  triangles));
  nlohmann::json rows = print_table(pictures);
  rows[0].update({{"level", level}, {"triangles", triangles}});
  write_pictures(picture.output, pictures);
  if (!picture.output.report.empty()) write_report(picture, scenes.first, {*context}, rows);
  return 0;
}

}  // namespace multum
