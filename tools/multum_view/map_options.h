// SPDX-License-Identifier: Apache-2.0
// Defines the options for pictures and frames of a baked map.
#pragma once

#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/parameter_values.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/render/reference_sampling.h"
#include "tools/multum_view/drawing_options.h"

namespace multum {

/// The inputs of the bake. They are needed for the reference, the baselines, and levels that the file does not contain.
struct SourceOptions {
  std::string normals;                         // normal map; if empty, level 0 of the file is used
  std::string albedo;                          // needs `normals`, like the next three
  std::string roughness;                       // FILE or FILE:CHANNEL
  std::string gloss;                           // replaces roughness, which is then 1 - gloss
  std::string weights;                         // blend weights of basis BRDFs
  ParameterValues reading{bake_parameters()};  // settings for reading `normals` that differ from the bake's settings
};

struct ComparisonOptions {
  std::vector<std::string> pictures;  // the form that parse_compared() returns
  gl::ReferenceSampling sampling;
  std::string kept_reference;  // file of the reference; if empty, the reference is always drawn
  gl::NormalMaterial::Sampling reference = gl::NormalMaterial::Sampling::kNearest;  // kNearest or kFootprint

  bool is_of_texels() const { return reference == gl::NormalMaterial::Sampling::kFootprint; }
};

struct AnimationOptions {
  std::string folder;  // folder of the frames; if empty, one picture is drawn
  int frame_count = 24;
  // The settings of the last frame. If a setting is unset or empty, the setting of the first frame is used.
  std::optional<CameraPlace> camera;
  std::string brdf;
  std::optional<glm::vec3> diffuse, specular;
  std::vector<gl::Light> lights;
  std::vector<gl::PointLight> point_lights;
  std::string environment;  // must have the same size as the first frame's environment
  std::optional<float> environment_turn;

  bool changes_anything() const {
    return camera || !brdf.empty() || diffuse || specular || !lights.empty() || !point_lights.empty() ||
           !environment.empty() || environment_turn;
  }
};

struct MapOptions {
  std::string file;          // *.ndf.exr
  std::string plan, object;  // replace `file`: plan.json of a scene, and the name of an object
  bool stored_only = false;  // do not draw levels finer than the stored ones, so that no source is needed
  PictureOptions picture;
  SourceOptions source;
  ComparisonOptions comparison;
  AnimationOptions animation;
  std::string brdf_roughness;  // FILE or FILE:CHANNEL that multiplies GGX's roughness; empty if there is none
  std::string shaders;         // JSON file for the shader variants that were used; empty if none is written
};

/// Adds all options except the map itself, output paths, and the changes between frames.
void add_map_options(CLI::App& app, MapOptions& options);
/// Adds --pictures, which writes each picture of a sheet to its own file.
void add_pictures_option(CLI::App& app, OutputOptions& options);
/// Adds --alone, which animate does not support.
void add_alone_option(CLI::App& app, OutputOptions& options);
/// Adds --frames, --to-camera and similar options.
void add_animation_options(CLI::App& app, AnimationOptions& options);

/// Throws Error(kUsage) for options that exclude each other with any map.
void check_map_options(const MapOptions& options);

/// Draws a baked map as one picture, a sheet or frames.
int draw_map(MapOptions options);

}  // namespace multum
