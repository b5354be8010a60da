// SPDX-License-Identifier: Apache-2.0
// multum-view lod: draws a pyramid of heights or positions as a mesh of one level of detail (Williams 1983, section 5).
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/asset/pyramid/pyramid_surface.h"
#include "host/base/error.h"
#include "host/base/files/output_paths.h"
#include "host/base/log.h"
#include "host/base/shown_text.h"
#include "host/mesh/tangent_space.h"
#include "runtime_gl/materials/normal_material.h"
#include "tools/multum_view/modes.h"
#include "tools/multum_view/view_inputs.h"
#include "tools/multum_view/view_outputs.h"
#include "tools/multum_view/write_image.h"

namespace multum {

void add_lod_options(CLI::App& app, LodOptions& options) {
  PictureOptions& picture = options.picture;
  app.add_option("file", options.file, "pyramid of heights or positions, as multum lod writes it")->required();
  add_picture_option(app, picture.output)->required();
  add_level_option(app, options);
  add_camera_options(app, picture.camera);
  add_light_options(app, picture.light);
  add_material_options(app, picture.material);
  add_output_options(app, picture.output);
  add_context_option(app, picture.context);
}

CLI::Option* add_level_option(CLI::App& app, LodOptions& options) {
  return app.add_option("--level", options.level, "level of detail, any number from 0")
      ->check(number_in(0.0f, 32.0f))
      ->capture_default_str();
}

int draw_lod(const LodOptions& options) {
  const PictureOptions& picture = options.picture;
  check_picture_path(picture.output.path);
  check_paths_differ({options.file}, {picture.output.path, picture.output.report});
  ViewScenes scenes = make_scenes(picture);
  const Pyramid pyramid = read_pyramid(options.file);
  if (pyramid.header.kind != PyramidKind::kHeight && pyramid.header.kind != PyramidKind::kPosition)
    throw Error(ErrorCode::kInput, fmt::format("{}: found a pyramid of {}, expected one of heights or positions",
                                               options.file, pyramid_kind_name(pyramid.header.kind)));
  const PyramidSurface surface = surface_at_level(pyramid, static_cast<double>(options.level));
  TriangleMesh mesh;
  mesh.positions = surface.positions;
  mesh.normals = surface.normals;
  mesh.uvs = surface.uvs;
  mesh.indices = surface.indices;
  for (const glm::vec3& n : mesh.normals) mesh.tangents.emplace_back(any_orthogonal(n), 1.0f);  // nothing is mapped
  frame_mesh(mesh, options.file, picture.output, scenes);
  const std::unique_ptr<gl::HeadlessContext> context = gl::make_headless_context(picture.context);
  log_info(context->description());
  const gl::NormalMaterial flat(context->functions(), {1, 1, {{0.0f, 0.0f, 1.0f}}, {}},
                                gl::NormalMaterial::Sampling::kNearest, 1.0f);
  gl::Renderer renderer(context->functions(), picture.output.width(), picture.output.height());
  const gl::Mesh drawn(context->functions(), to_mesh_data(mesh));
  const std::vector<NamedPicture> pictures = {{"lod", renderer.draw(drawn, flat, scenes.first)}};
  write_shown(stdout, fmt::format("level {:g}: {} x {} points, {} triangles\n", options.level, surface.columns,
                                  surface.rows, surface.indices.size() / 3));
  const nlohmann::json rows = print_table(pictures);
  write_pictures(picture.output, pictures);
  if (!picture.output.report.empty()) write_report(picture, scenes.first, {context->description()}, rows);
  return 0;
}

}  // namespace multum
