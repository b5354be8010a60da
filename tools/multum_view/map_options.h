// SPDX-License-Identifier: Apache-2.0
// The options of a baked map's pictures and frames.
#pragma once

#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/parameter_values.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/render/reference_sampling.h"
#include "tools/multum_view/drawing_options.h"

namespace multum {

/// What the file was baked from, for the reference, the baselines and levels that it does not hold.
struct SourceOptions {
  std::string normals;                         // empty: level 0 of the file
  std::string albedo;                          // used where `normals` is, as the next three
  std::string roughness;                       // FILE or FILE:CHANNEL
  std::string gloss;                           // in its place: roughness = 1 - gloss
  std::string weights;                         // of basis BRDFs
  ParameterValues reading{bake_parameters()};  // how to read `normals`, where it is not read as the bake read it
};

struct ComparisonOptions {
  std::vector<std::string> pictures;  // as parse_compared() gives them
  gl::ReferenceSampling sampling;
  std::string kept_reference;  // a file; empty: the reference is drawn anew
  gl::NormalMaterial::Sampling reference = gl::NormalMaterial::Sampling::kNearest;  // kFootprint: --reference-of texels

  bool is_of_texels() const { return reference == gl::NormalMaterial::Sampling::kFootprint; }
};

struct AnimationOptions {
  std::string folder;  // of the frames; empty: one picture
  int frame_count = 24;
  // Of the last frame; unset or empty: as the first.
  std::optional<CameraPlace> camera;
  std::string brdf;
  std::optional<glm::vec3> diffuse, specular;
  std::vector<gl::Light> lights;
  std::vector<gl::PointLight> point_lights;
  std::string environment;  // of the size of the first frame's
  std::optional<float> environment_turn;

  bool changes_anything() const {
    return camera || !brdf.empty() || diffuse || specular || !lights.empty() || !point_lights.empty() ||
           !environment.empty() || environment_turn;
  }
};

struct MapOptions {
  std::string file;          // *.ndf.exr
  std::string plan, object;  // of a scene, in the place of `file`: plan.json, and which of its objects
  bool stored_only = false;  // levels finer than those that the file holds are never seen: no source for them
  PictureOptions picture;
  SourceOptions source;
  ComparisonOptions comparison;
  AnimationOptions animation;
  std::string brdf_roughness;  // of GGX, FILE or FILE:CHANNEL, times its own; empty: none
  std::string shaders;         // JSON of the variants that were drawn with; empty: none
};

/// All but the map itself, where pictures go, and what changes from frame to frame.
void add_map_options(CLI::App& app, MapOptions& options);
/// --pictures: each picture of a sheet in a file of its own.
void add_pictures_option(CLI::App& app, OutputOptions& options);
/// --alone, of what is drawn without animate.
void add_alone_option(CLI::App& app, OutputOptions& options);
/// --frames, --to-camera, ...
void add_animation_options(CLI::App& app, AnimationOptions& options);

/// Throws Error(kUsage) for options that do not go together, whatever the map holds.
void check_map_options(const MapOptions& options);

/// Draws a baked map: one picture, a sheet, or frames.
int draw_map(MapOptions options);

}  // namespace multum
