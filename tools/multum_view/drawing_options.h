// SPDX-License-Identifier: Apache-2.0
// The options of pictures, a struct for each subject, and the functions that add them to a command line. Every option
// that a scene's plan may state too is unset, or empty, until it is given (scene_plan.h).
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/foundation/parameters/parameter_choices.h"
#include "tools/multum_view/option_values.h"

namespace multum {

struct SurfaceOptions {
  std::string mesh;             // empty: the plane
  std::optional<float> repeat;  // of the map; unset: 60 across the plane, 1 on a mesh
};

struct CameraOptions {
  std::optional<CameraPlace> place;  // unset: over the plane; seeing the whole mesh
  std::optional<glm::vec3> up;       // unit; unset: +Z over the plane, +Y with a mesh
  std::vector<float> distances;      // of pictures, times the camera's own; empty: one picture from there
};

struct LightOptions {
  std::vector<gl::Light> distant;  // no light of any kind: the usual one
  std::vector<gl::PointLight> points;
  std::string environment;                              // over latitude and longitude; empty: none
  std::optional<gl::EnvironmentMode> environment_mode;  // unset: prefiltered
  std::optional<float> environment_turn;                // degrees about what is up; unset: 0
  bool no_background = false;                           // black where nothing stands, not the environment
};

struct MaterialOptions {
  std::vector<std::string> brdfs;  // as parse_brdf() takes them; several: blended by the map's weights
  int term_count = Brdf{}.term_count;
  std::vector<glm::vec3> diffuse, specular;  // one for all BRDFs, or one each; empty: the BRDF's own
  std::optional<glm::vec3> fixed_fresnel;
};

struct ShadingOptions {
  gl::LobeFormula formula = gl::LobeFormula::kProduct;
  bool shade_first = false;                  // lobes are shaded before they are filtered
  std::optional<MapSurface> surface;         // between texels of lobes of level 0; unset: as the reference has it
  std::optional<gl::MomentShading> moments;  // of files of moments; unset: kDefaultMomentShading
  std::string colour_map;                    // a pyramid of multum mip: the colours of all lobes; empty: the file's own
  gl::TextureFilter filter;                  // of every mip-mapped texture; its bias and evaluations are below
  std::optional<int> evaluations;            // of a pixel's light, 0 to 16; unset: kEvaluationsOfLobes
  std::optional<float> level_bias;           // unset: kLevelBiasDefault; -16..16
  float anisotropy = 1.0f;                   // of the driver's filter; 1..16
};

struct OutputOptions {
  std::string path;                 // *.png, *.exr
  bool is_alone = false;            // `path` shows the baked map, and not what it is compared with
  std::string pictures;             // PREFIX of a file for each picture; empty: none
  std::string report;               // JSON; empty: none
  std::optional<PictureSize> size;  // unset: 640 x 480
  float exposure = 1.0f;            // PNG only

  int width() const { return size.value_or(PictureSize{}).width; }
  int height() const { return size.value_or(PictureSize{}).height; }
};

/// What baked maps, models and surfaces of a level of detail have in common.
struct PictureOptions {
  SurfaceOptions surface;
  CameraOptions camera;
  LightOptions light;
  MaterialOptions material;
  ShadingOptions shading;
  OutputOptions output;
  gl::ContextBackend context = gl::ContextBackend::kAuto;
};

void add_mesh_option(CLI::App& app, SurfaceOptions& options);
void add_repeat_option(CLI::App& app, SurfaceOptions& options);
/// --camera, --up.
void add_camera_options(CLI::App& app, CameraOptions& options);
void add_distance_option(CLI::App& app, CameraOptions& options);
/// --light, --point-light.
void add_light_options(CLI::App& app, LightOptions& options);
/// --brdf, --diffuse, ...
void add_material_options(CLI::App& app, MaterialOptions& options);
/// -o for a picture.
CLI::Option* add_picture_option(CLI::App& app, OutputOptions& options);
/// --report, --size, --exposure.
void add_output_options(CLI::App& app, OutputOptions& options);
/// --level-bias.
CLI::Option* add_level_bias_option(CLI::App& app, std::optional<float>& bias, const std::string& help);
void add_context_option(CLI::App& app, gl::ContextBackend& context);
/// Adds what every drawn baked map has: lights, an environment, materials, ways to shade, outputs but -o, the GL.
void add_rendering_options(CLI::App& app, PictureOptions& options);

}  // namespace multum
