// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/pyramid/surface_detail.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/trigonometric.hpp>

#include "host/formats/mesh/tangent_space.h"
#include "host/foundation/base/error.h"
#include "tools/multum_view/option_values.h"

namespace multum {
namespace {

CLI::Option* add_level(CLI::App& app, const std::string& name, DetailOptions& options) {
  return app.add_option(name, options.level, "set the level of detail, which may be a fraction (default: 0)")
      ->check(number_in(0.0f, 32.0f));
}

void add_spacing(CLI::App& app, const std::string& name, CLI::Option* level, DetailOptions& options) {
  app.add_option(name, options.spacing, "choose the level whose neighbouring points are this many pixels apart")
      ->check(number_in(0.01f, 1000.0f))
      ->excludes(level);
}

}  // namespace

void add_detail_options(CLI::App& app, DetailOptions& options) {
  add_spacing(app, "--point-spacing", add_level(app, "--level", options), options);
}

void add_surface_detail_options(CLI::App& app, DetailOptions& options) {
  add_spacing(app, "--surface-spacing", add_level(app, "--surface-level", options), options);
}

Pyramid read_surface_pyramid(const std::string& path) {
  Pyramid pyramid = read_pyramid(path);
  if (pyramid.header.kind != PyramidKind::kHeight && pyramid.header.kind != PyramidKind::kPosition)
    throw Error(ErrorCode::kInput, fmt::format("{}: found a pyramid of {}, expected a pyramid of heights or positions",
                                               path, pyramid_kind_name(pyramid.header.kind)));
  return pyramid;
}

double detail_level(const DetailOptions& options, const Pyramid& pyramid, const gl::Camera& camera, int height) {
  if (!options.spacing) return static_cast<double>(options.level.value_or(0.0f));
  const double half_angle = glm::radians(0.5 * static_cast<double>(camera.fov_y_degrees));
  return level_of_projection(pyramid, {glm::dvec3(camera.eye), 0.5 * height / std::tan(half_angle)},
                             static_cast<double>(*options.spacing));
}

TriangleMesh to_triangle_mesh(const PyramidSurface& surface) {
  TriangleMesh mesh;
  mesh.positions = surface.positions;
  mesh.normals = surface.normals;
  mesh.uvs = surface.uvs;
  mesh.indices = surface.indices;
  for (const glm::vec3& n : mesh.normals) mesh.tangents.emplace_back(any_orthogonal(n), 1.0f);
  return mesh;
}

}  // namespace multum
