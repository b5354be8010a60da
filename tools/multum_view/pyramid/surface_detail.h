// SPDX-License-Identifier: Apache-2.0
// Options for the level of detail of a surface that is read from a pyramid of heights or positions.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "host/formats/asset/pyramid/pyramid_surface.h"
#include "host/formats/mesh/mesh.h"
#include "runtime_gl/render/camera.h"

namespace multum {

struct DetailOptions {
  std::optional<float> level;    // if not set, 0 or the level that `spacing` chooses
  std::optional<float> spacing;  // pixels between neighbouring points
};

/// Adds --level and --point-spacing.
void add_detail_options(CLI::App& app, DetailOptions& options);
/// Adds --surface-level and --surface-spacing, for a surface other than the drawn file.
void add_surface_detail_options(CLI::App& app, DetailOptions& options);

/// Throws Error(kInput) if the pyramid holds neither heights nor positions.
Pyramid read_surface_pyramid(const std::string& path);
/// Returns the level of detail. `height` is the picture's height in pixels.
double detail_level(const DetailOptions& options, const Pyramid& pyramid, const gl::Camera& camera, int height);
/// Converts a surface. Its tangents are arbitrary, because it has no map.
TriangleMesh to_triangle_mesh(const PyramidSurface& surface);

}  // namespace multum
