// SPDX-License-Identifier: Apache-2.0
// Draws one surface under one light with every filtering method. A picture is a square of pixels. The distance
// determines the number of finest texels per pixel. The reference shades every finest texel that a pixel covers.
#pragma once

#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/delivery/export/export_source.h"
#include "host/delivery/export/report/level_textures.h"

namespace multum {

constexpr int kFrameSide = 96;  // side of a picture in pixels

/// The camera and the light.
struct FrameView {
  double level = 2.0;           // log2 of a pixel's side, in finest texels: 2..6
  glm::dvec2 middle{0.0};       // middle of the picture, in finest texels
  glm::dvec2 half_vector{0.0};  // slopes in the middle of the picture
};

/// The highlights D V (n . l), row by row.
using FramePixels = std::vector<double>;

/// A filtering method with its textures.
struct SurfaceModel {
  enum class Kind { kOneLobe, kBakedLobes };
  std::string id, name;
  Kind kind = Kind::kOneLobe;
  LevelTexture texture;
};

/// Draws a model with `texture`. For kOneLobe, the texture holds normal and roughness and, if it has 7 channels, also
/// axis and strength. For kBakedLobes, it holds (a r, a) per lobe, and the roughness is taken from `averages`
/// (averaged_levels()).
FramePixels draw_model(const SurfaceModel& model, const LevelTexture& averages, const FrameView& view, int map_width,
                       int map_height, int threads);

/// Draws all finest texels that each pixel covers. If `material` is null, `alpha_squared` is used.
FramePixels draw_reference(const PlaneStore& normals, const PlaneStore* material, double alpha_squared,
                           const FrameView& view, int threads);

}  // namespace multum
