// SPDX-License-Identifier: Apache-2.0
// The level of detail of a surface that comes from a pyramid of heights or positions, as options state it.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "host/formats/asset/pyramid/pyramid_surface.h"
#include "host/formats/mesh/mesh.h"
#include "runtime_gl/render/camera.h"

namespace multum {

struct DetailOptions {
  std::optional<float> level;    // unset: 0, or by `spacing`
  std::optional<float> spacing;  // pixels between neighbouring points
};

/// --level, --point-spacing.
void add_detail_options(CLI::App& app, DetailOptions& options);
/// --surface-level, --surface-spacing: of a surface beside the file that is drawn.
void add_surface_detail_options(CLI::App& app, DetailOptions& options);

/// Throws Error(kInput) where the file is a pyramid of something else than heights or positions.
Pyramid read_surface_pyramid(const std::string& path);
/// `height`: of the picture, in pixels.
double detail_level(const DetailOptions& options, const Pyramid& pyramid, const gl::Camera& camera, int height);
/// Without a map: tangents are any.
TriangleMesh to_triangle_mesh(const PyramidSurface& surface);

}  // namespace multum
