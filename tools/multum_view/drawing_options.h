// SPDX-License-Identifier: Apache-2.0
// Defines the options of pictures, with one struct per subject, and functions that add the options to a command line.
// An option that can also be set in a scene plan stays unset or empty if the command line does not contain it
// (scene_plan.h).
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/foundation/parameters/parameter_choices.h"
#include "tools/multum_view/option_values.h"

namespace multum {

struct SurfaceOptions {
  std::string mesh;             // mesh file; empty for the plane
  std::optional<float> repeat;  // repeats of the map; if not set, 60 across the plane, 1 on a mesh
};

struct CameraOptions {
  std::optional<CameraPlace> place;  // if not set, above the plane, or where the whole mesh is visible
  std::optional<glm::vec3> up;       // unit vector; if not set, +Z over the plane, +Y with a mesh
  std::vector<float> distances;      // factors by which the camera's distance is multiplied, one picture per factor; if
                                     // empty, one picture is drawn
};

struct LightOptions {
  std::vector<gl::Light> distant;  // if there is no light at all, the default light is used
  std::vector<gl::PointLight> points;
  std::string environment;                              // latitude-longitude image; empty if there is none
  std::optional<gl::EnvironmentMode> environment_mode;  // prefiltered if not set
  std::optional<float> environment_turn;                // degrees about the up axis; 0 if not set
  bool no_background = false;                           // draw black instead of the environment behind the surface
};

struct MaterialOptions {
  std::vector<std::string> brdfs;  // in the form that parse_brdf() accepts; several BRDFs are blended by the map's
                                   // weights
  int term_count = Brdf{}.term_count;
  std::vector<glm::vec3> diffuse, specular;  // one colour for all BRDFs, or one for each; if empty, the BRDF's own
                                             // colours are used
  std::optional<glm::vec3> fixed_fresnel;
};

struct ShadingOptions {
  gl::LobeFormula formula = gl::LobeFormula::kProduct;
  bool shade_first = false;                  // shade lobes before filtering them
  std::optional<MapSurface> surface;         // surface between lobe texels of level 0; as in the reference if not set
  std::optional<gl::MomentShading> moments;  // for files of moments; kDefaultMomentShading if not set
  std::string colour_map;           // pyramid of multum mip that colours all lobes; if empty, the file's own colours
                                    // are used
  gl::TextureFilter filter;         // filter of every mip-mapped texture; its bias and evaluations are set below
  std::optional<int> evaluations;   // shading evaluations per pixel, 0 to 16; kEvaluationsOfLobes if not set
  std::optional<float> level_bias;  // -16..16; kLevelBiasDefault if not set
  float anisotropy = 1.0f;          // anisotropy of the driver's filter, 1..16
};

struct OutputOptions {
  std::string path;                 // *.png or *.exr
  bool is_alone = false;            // `path` shows only the baked map, without the compared pictures
  std::string pictures;             // name prefix for one file per picture; empty if there are no such files
  std::string report;               // JSON file; empty if no report is written
  std::optional<PictureSize> size;  // 640 x 480 if not set
  float exposure = 1.0f;            // for PNG only

  int width() const { return size.value_or(PictureSize{}).width; }
  int height() const { return size.value_or(PictureSize{}).height; }
};

/// The options that are common to baked maps, models and level-of-detail surfaces.
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
/// Adds --camera and --up.
void add_camera_options(CLI::App& app, CameraOptions& options);
void add_distance_option(CLI::App& app, CameraOptions& options);
/// Adds --light and --point-light.
void add_light_options(CLI::App& app, LightOptions& options);
/// Adds --brdf, --diffuse and so on.
void add_material_options(CLI::App& app, MaterialOptions& options);
/// Adds -o for a picture.
CLI::Option* add_picture_option(CLI::App& app, OutputOptions& options);
/// Adds --report, --size and --exposure.
void add_output_options(CLI::App& app, OutputOptions& options);
/// Adds --level-bias.
CLI::Option* add_level_bias_option(CLI::App& app, std::optional<float>& bias, const std::string& help);
void add_context_option(CLI::App& app, gl::ContextBackend& context);
/// Adds the options for drawing any baked map, which are the lights, the environment, materials, shading, outputs
/// except -o, and GL.
void add_rendering_options(CLI::App& app, PictureOptions& options);

}  // namespace multum
