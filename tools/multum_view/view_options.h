// SPDX-License-Identifier: Apache-2.0
// The command line of multum-view.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/parameters/bake_parameters.h"
#include "host/parameters/parameter_values.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/render/scene.h"

namespace multum {

struct ViewOptions {
  std::string input;            // *.ndf.exr
  std::string output;           // *.png, *.exr
  std::string pictures;         // PREFIX of a file for each picture; empty: none
  std::string source;           // normal map that the file was baked from; empty: level 0 of the file
  std::string albedo;           // its colours; used where `source` is
  std::string colour_map;       // a pyramid of multum mip: the colours of all lobes; empty: the file's own
  bool stored_only = false;     // levels finer than those that the file holds are never seen: no source for them
  std::string roughness;        // FILE or FILE:CHANNEL; the same
  std::string gloss;            // in its place: roughness = 1 - gloss
  bool brdf_is_in_map = false;  // each texel of the file has its own roughness, whatever `scene` says
  std::string weights;          // of basis BRDFs; the same
  ParameterValues reading{bake_parameters()};  // how to read `source`, where it is not read as the bake read it
  std::string mesh;                            // empty: the plane
  std::string environment;                     // over latitude and longitude; empty: none
  bool no_background = false;                  // black where nothing stands, not the environment
  std::string report;                          // JSON; empty: none
  std::string shaders;                         // JSON of the variants that were drawn with; empty: none
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  gl::RenderScene scene;
  std::vector<Brdf> basis;  // what --brdf says, more than one: blended by the file's weights
  bool has_brdf = false;    // --brdf was given: it is not the usual one
  bool has_camera = false;
  std::vector<float> distances;  // of pictures, times the camera's own; empty: one picture from there
  std::string frames_folder;     // of --animate; empty: one picture
  int frame_count = 24;
  gl::RenderScene last_scene;  // of the last frame
  bool has_last_camera = false;
  glm::vec3 up{0.0f, 0.0f, 1.0f};  // unit; the camera's, also where the camera frames the mesh
  gl::LobeFormula formula = gl::LobeFormula::kProduct;
  std::optional<gl::MomentShading> moments;  // of files of moments; unset: the usual one
  std::vector<std::string> compare;          // of truth, mip, toksvig, lean, lean-jacobian
  int width = 640;
  int height = 480;
  int samples = 256;             // a pixel of the truth
  bool shade_first = false;      // lobes are shaded before they are filtered
  bool truth_of_texels = false;  // the truth averages over what a trilinear filter does, not over the pixel
  float repeat = 0.0f;           // 0: 60 across the plane, 1 on a mesh
  float anisotropy = 1.0f;
  float exposure = 1.0f;  // PNG only
  // What is drawn in the place of `input` (docs/WILLIAMS.md): a pyramid of one kind, or a model's own materials.
  std::string mip, reflectance, lod;
  std::vector<std::string> lookups;    // of mip and reflectance: truth, nearest, bilinear, level, driver
  std::optional<float> level_bias;     // unset: 0 for mip, the pixel's own width for reflectance
  int shifts = 0;                      // of reflectance: pictures that flicker is measured on
  float level = 0.0f;                  // of lod
  std::vector<std::string> materials;  // NAME=FILE.ndf.exr
};

/// Unset when the program is done already (--help); `exit_code` then says how. Throws Error(kUsage) for a bad value.
std::optional<ViewOptions> parse_view_options(int argc, char** argv, int* exit_code);

}  // namespace multum
