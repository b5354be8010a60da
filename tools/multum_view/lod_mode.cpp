// SPDX-License-Identifier: Apache-2.0
// multum-view --lod: a pyramid of heights or positions as a mesh of one level of detail (Williams 1983, section 5).
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

namespace multum {

int run_lod(ViewOptions& options) {
  check_paths_differ({options.lod}, {options.output, options.report});
  const Pyramid pyramid = read_pyramid(options.lod);
  if (pyramid.header.kind != PyramidKind::kHeight && pyramid.header.kind != PyramidKind::kPosition)
    throw Error(ErrorCode::kInput, fmt::format("{}: found a pyramid of {}, expected one of heights or positions",
                                               options.lod, pyramid_kind_name(pyramid.header.kind)));
  const PyramidSurface surface = surface_at_level(pyramid, static_cast<double>(options.level));
  TriangleMesh mesh;
  mesh.positions = surface.positions;
  mesh.normals = surface.normals;
  mesh.uvs = surface.uvs;
  mesh.indices = surface.indices;
  for (const glm::vec3& n : mesh.normals) mesh.tangents.emplace_back(any_orthogonal(n), 1.0f);  // nothing is mapped
  frame_mesh(mesh, options);
  const std::unique_ptr<gl::HeadlessContext> context = gl::make_headless_context(options.context);
  log_info(context->description());
  const gl::NormalMaterial flat(context->functions(), {1, 1, {{0.0f, 0.0f, 1.0f}}, {}},
                                gl::NormalMaterial::Sampling::kNearest, 1.0f);
  gl::Renderer renderer(context->functions(), options.width, options.height);
  const gl::Mesh drawn(context->functions(), to_mesh_data(mesh));
  const std::vector<NamedPicture> pictures = {{"lod", renderer.draw(drawn, flat, options.scene)}};
  write_shown(stdout, fmt::format("level {:g}: {} x {} points, {} triangles\n", options.level, surface.columns,
                                  surface.rows, surface.indices.size() / 3));
  const nlohmann::json rows = print_table(pictures);
  write_pictures(options, pictures);
  if (!options.report.empty()) write_report(options, context->description(), rows);
  return 0;
}

}  // namespace multum
