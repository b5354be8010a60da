// SPDX-License-Identifier: Apache-2.0
// Declares the subcommands of multum-view besides drawing baked maps (map_options.h): for each its options, a function
// that adds them to its command line, and one that runs it and returns the exit code.
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
  std::string request;  // JSON (host/fields/inferred/probe_request.h)
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  int threads = 0;  // of decoding; 0: all cores
  bool matrix_market = false;
};
void add_probe_options(CLI::App& app, ProbeOptions& options);
/// Measures filter matrices for texture inference.
int measure_filter_matrices(const ProbeOptions& options);

struct SampleOptions {
  std::string folder;                // what multum infer wrote, or its inferred.json
  std::vector<std::string> samples;  // "3,5", or a name
  std::vector<std::string> outputs;  // one each
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  float exposure = 1.0f;
};
void add_sample_options(CLI::App& app, SampleOptions& options);
/// Draws objects with the textures inferred for them.
int draw_samples(const SampleOptions& options);

struct PlayOptions {
  std::string file;  // of multum pack
  std::string path;  // host/fields/playback/parameter_path.h, or a file, host/fields/playback/recorded_path.h
  std::string folder;
  int frame_count = 0;    // 0: 24, or all of a recorded path
  float rate = 30.0f;     // frames a second
  int supersampling = 0;  // sub-pixels along each side of a pixel; 0: the field's
  bool is_linear = false;
  bool is_cold = false;              // forgets all before each frame
  bool draws_what_is_there = false;  // else waits for all that a frame needs
  int ahead = 8;                     // frames
  std::string memory = "256M", upload = "16M";
  float lifetime = 20.0f, lifetime_factor = 4.0f;
  int threads = 0;            // of decoding; 0: all cores
  std::string debug_picture;  // empty: none
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  float exposure = 1.0f;
};
void add_play_options(CLI::App& app, PlayOptions& options);
/// Draws frames along a path through the parameters.
int play_field(const PlayOptions& options);

struct ThumbnailOptions {
  std::string result;  // *.ndf.exr, or what multum infer wrote
  std::string folder;
  std::string source, albedo;  // what was baked; empty: only the result is shown
  gl::ContextBackend context = gl::ContextBackend::kAuto;
};
void add_thumbnail_options(CLI::App& app, ThumbnailOptions& options);
/// Draws small pictures of a job's input and result, for the page of the service.
int draw_thumbnails(const ThumbnailOptions& options);
constexpr int kThumbnailSide = 512;  // of the input's, at most
/// The same for a folder of multum infer: a frame of the first sample, as multum-view sample draws it. Throws
/// Error(kUsage) in a build without fields.
void draw_field_thumbnail(const ThumbnailOptions& options);

struct EachOptions {
  std::string file;  // JSON: command lines
};
void add_each_options(CLI::App& app, EachOptions& options);
/// Runs command lines one after another, up to the first that fails.
int run_each(const EachOptions& options);

struct PyramidOptions {
  std::string file;
  std::optional<PyramidKind> expected;  // of the file; unset: colours or reflected light
  SurfaceOptions surface;
  std::string surface_pyramid;  // in the place of surface.mesh, at `detail` but for the reference; empty: none
  DetailOptions detail;
  CameraOptions camera;
  OutputOptions output;
  std::vector<std::string> lookups = {"level"};  // reference, nearest, bilinear, level, driver
  std::optional<float> level_bias;               // unset: 0 for colours, the pixel's own width for reflected light
  int shifts = 0;                                // pictures that flicker is measured on; 0: it is not
  int samples = 256;                             // of the reference, per pixel
  float anisotropy = 1.0f;
  gl::ContextBackend context = gl::ContextBackend::kAuto;
};
void add_pyramid_options(CLI::App& app, PyramidOptions& options);
/// Draws a surface coloured straight from a pyramid.
int draw_pyramid(const PyramidOptions& options);

struct LodOptions {
  std::string file;
  DetailOptions detail;
  std::optional<int> patch_steps;  // cells along a side of a bicubic patch; unset: points are corners of triangles
  PictureOptions picture;
};
void add_lod_options(CLI::App& app, LodOptions& options);
/// Draws a pyramid of heights or positions as a mesh of one level.
int draw_lod(const LodOptions& options);

struct ModelOptions {
  PictureOptions picture;              // the model is the surface
  std::vector<std::string> materials;  // NAME=FILE.ndf.exr
};
void add_model_options(CLI::App& app, ModelOptions& options);
/// Draws a model with its own materials, each with a map baked for it.
int draw_model(const ModelOptions& options);

}  // namespace multum
