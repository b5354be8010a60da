// SPDX-License-Identifier: Apache-2.0
// Pictures of one surface under one light by every way to filter it: a square of pixels, each of which covers as many
// finest texels as the distance says. The reference shades every finest texel under a pixel.
#pragma once

#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/delivery/export/export_source.h"
#include "host/delivery/export/report/level_textures.h"

namespace multum {

constexpr int kFrameSide = 96;  // pixels

/// Where the camera and the light are.
struct FrameView {
  double level = 2.0;           // log2 of a pixel's side, in finest texels: 2..6
  glm::dvec2 middle{0.0};       // of the picture, in finest texels
  glm::dvec2 half_vector{0.0};  // its slopes in the middle of the picture
};

/// Highlights, D V (n . l), row by row.
using FramePixels = std::vector<double>;

/// A way to filter the surface, with the textures that it reads.
struct SurfaceModel {
  enum class Kind { kOneLobe, kBakedLobes };
  std::string id, name;
  Kind kind = Kind::kOneLobe;
  LevelTexture texture;
};

/// Draws what `texture` holds. kOneLobe: normal and roughness, and axis and strength where it has 7 channels;
/// kBakedLobes: (a r, a) a lobe, under the roughness that `averages` (averaged_levels()) have.
FramePixels draw_model(const SurfaceModel& model, const LevelTexture& averages, const FrameView& view, int map_width,
                       int map_height, int threads);

/// Draws all finest texels under each pixel. `alpha_squared`: where `material` is null.
FramePixels draw_reference(const PlaneStore& normals, const PlaneStore* material, double alpha_squared,
                           const FrameView& view, int threads);

}  // namespace multum
