// SPDX-License-Identifier: Apache-2.0
// Declares the subcommands of multum-view, except those that draw baked maps (map_options.h). Each subcommand has
// options, a function that adds them to its command line, and a function that runs it and returns the exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/asset/pyramid/pyramid_file.h"
#include "tools/multum_view/map_options.h"
#include "tools/multum_view/pyramid/surface_detail.h"

namespace multum {

struct ProbeOptions {
  std::string request;  // JSON file (host/fields/inferred/probe_request.h)
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  int threads = 0;  // threads for decoding; 0 means all cores
  bool matrix_market = false;
};
void add_probe_options(CLI::App& app, ProbeOptions& options);
/// Measures filter matrices for texture inference.
int measure_filter_matrices(const ProbeOptions& options);

struct SampleOptions {
  std::string folder;                // output folder of multum infer, or its inferred.json
  std::vector<std::string> samples;  // sample numbers such as "3,5", or a name
  std::vector<std::string> outputs;  // one output per sample
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  float exposure = 1.0f;
};
void add_sample_options(CLI::App& app, SampleOptions& options);
/// Draws objects with their inferred textures.
int draw_samples(const SampleOptions& options);

struct PlayOptions {
  std::string file;  // a file that multum pack wrote
  std::string path;  // a path (host/fields/playback/parameter_path.h) or a file (host/fields/playback/recorded_path.h)
  std::string folder;
  int frame_count = 0;    // if 0, 24, or all frames of a recorded path
  float rate = 30.0f;     // frames per second
  int supersampling = 0;  // sub-pixels along each side of a pixel; if 0, the number in the field is used
  bool is_linear = false;
  bool writes_exr = false;           // write frame_0000.exr with linear floats instead of frame_0000.png
  bool is_cold = false;              // forget all decoded data before each frame
  bool draws_what_is_there = false;  // if false, playback waits for all data of each frame
  int ahead = 8;                     // number of frames to decode ahead
  std::string memory = "256M", upload = "16M";
  float lifetime = 20.0f, lifetime_factor = 4.0f;
  int threads = 0;            // threads for decoding; 0 means all cores
  std::string debug_picture;  // PNG file; empty if none is written
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  float exposure = 1.0f;
};
void add_play_options(CLI::App& app, PlayOptions& options);
/// Draws frames along a path through the parameters.
int play_field(const PlayOptions& options);

struct ThumbnailOptions {
  std::string result;  // *.ndf.exr, or an output folder of multum infer
  std::string folder;
  std::string source, albedo;  // inputs of the bake; if empty, only the result is drawn
  gl::ContextBackend context = gl::ContextBackend::kAuto;
};
void add_thumbnail_options(CLI::App& app, ThumbnailOptions& options);
/// Draws small pictures of a job's input and result for the page of the service.
int draw_thumbnails(const ThumbnailOptions& options);
constexpr int kThumbnailSide = 512;  // largest side of the input's picture
/// Draws a frame of the first sample, as multum-view sample does, as the thumbnail of an output folder of multum infer.
/// Throws Error(kUsage) in a build without fields.
void draw_field_thumbnail(const ThumbnailOptions& options);

struct EachOptions {
  std::string file;  // JSON list of command lines
};
void add_each_options(CLI::App& app, EachOptions& options);
/// Runs command lines one after another until one fails.
int run_each(const EachOptions& options);

struct PyramidOptions {
  std::string file;
  std::optional<PyramidKind> expected;  // kind of the file; if not set, colours or reflected light
  SurfaceOptions surface;
  std::string surface_pyramid;  // pyramid that replaces surface.mesh, at level `detail` except in the reference; empty
                                // if there is none
  DetailOptions detail;
  CameraOptions camera;
  OutputOptions output;
  std::vector<std::string> lookups = {"level"};  // reference, nearest, bilinear, level or driver
  std::optional<float> level_bias;               // if not set, 0 for colours; for reflected light, it follows from the
                                                 // pixel's width
  int shifts = 0;                                // number of pictures for measuring flicker; if 0, it is not measured
  int samples = 256;                             // reference samples per pixel
  float anisotropy = 1.0f;
  gl::ContextBackend context = gl::ContextBackend::kAuto;
};
void add_pyramid_options(CLI::App& app, PyramidOptions& options);
/// Draws a surface whose colours come directly from a pyramid.
int draw_pyramid(const PyramidOptions& options);

struct LodOptions {
  std::string file;
  DetailOptions detail;
  std::optional<int> patch_steps;  // number of cells along each side of a bicubic patch; if not set, the points are
                                   // corners of triangles
  PictureOptions picture;
};
void add_lod_options(CLI::App& app, LodOptions& options);
/// Draws one level of a pyramid of heights or positions as a mesh.
int draw_lod(const LodOptions& options);

struct ModelOptions {
  PictureOptions picture;              // options of the picture, whose surface is the model
  std::vector<std::string> materials;  // NAME=FILE.ndf.exr
};
void add_model_options(CLI::App& app, ModelOptions& options);
/// Draws a model with its own materials. A baked map can replace the normal texture of each material.
int draw_model(const ModelOptions& options);

}  // namespace multum
