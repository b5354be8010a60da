// SPDX-License-Identifier: Apache-2.0
// Runs `multum infer`, which computes textures from a job (Hakura et al. 2000, section 3). Each object gets texture
// coordinates and filter matrices. Each of its layers gets one texture for each point of the parameters that the layer
// depends on. The texture is inferred from all samples of the point together (eq. 4). If an object is in no layer, it
// gets no textures.
//
// Each point is a neighbour of the point solved before, whose texture is the start value. Textures are written as soon
// as they are solved. An existing texture with the same inputs and settings is reused, so a stopped run can resume.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "host/fields/inference/pipeline/animation_probe.h"
#include "host/fields/inference/pipeline/parameterized_scene.h"
#include "host/fields/inference/solver/texture_inference.h"
#include "host/fields/inferred/inferred_texture.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct AnimationInferSettings {
  std::string output;            // folder
  std::string device;            // selector of Device::open()
  Device opened;                 // if this device is open, it is used instead of `device`
  std::string viewer;            // multum-view
  std::string context = "auto";  // OpenGL context of multum-view
  int threads = 1;
  bool has_absolute_geometry = false;  // store the scene file's absolute path instead of a relative one
  bool force = false;                  // infer existing textures again
  std::set<std::string> damaged;       // paths of existing textures that must not be reused
  int hold_out = 0;                    // N >= 2 leaves out every Nth sample along the views, in layers that do not
                                       // depend on the view; 0 leaves out none
  bool with_baseline = true;           // also measure forward mapping
  double gradient_tolerance = 1e-3;
  int iteration_max = 400;
};

/// Returns the device of the settings, and opens it if necessary. Throws Error(kEnvironment).
Device device_of(const AnimationInferSettings& settings);

/// One texture, and its error in each sample that it serves.
struct TextureResult {
  std::size_t object = 0;
  std::size_t layer = 0;
  std::size_t point = 0;               // index among the grid's points of the layer
  int block = 0;                       // block of the grid; selects the object's mapping
  std::vector<int> samples;            // indices of the job's samples
  std::vector<double> squared_errors;  // mean squared error of each sample over wholly covered pixels, 8-bit sRGB units
  std::vector<double> pixel_counts;
  std::vector<double> forward_squared_errors;  // errors of forward mapping; empty if not requested
  std::vector<bool> is_held_out;               // whether each sample is left out of solving
  std::string file;                            // relative to the output folder; empty if the layer is black
  bool was_there = false;
  bool converged = true;
  int iterations = 0;
  std::vector<InferenceStep> history;
};

struct StageSeconds {
  double mapping = 0.0, probing = 0.0, segmentation = 0.0, systems = 0.0, solving = 0.0, baseline = 0.0,
         rendering = 0.0;
};

/// The results of segmenting the pictures of one point of a layer, for all objects together.
struct PointReport {
  std::size_t layer = 0, point = 0;
  SegmentationReport segmentation;
};

/// The numbers of rows of the filter matrix of an object in a pose.
struct MatrixRows {
  int pose = 0;
  std::size_t object = 0;
  std::uint64_t rows = 0, rejected = 0;
};

struct AnimationInferResult {
  InferredManifest manifest;
  std::vector<TextureResult> textures;
  std::vector<std::string> blocks;  // names of the grid's blocks
  ObjectMappings mappings;          // texture mapping of each object in each block
  SegmentationReport segmentation;  // sum over all pictures
  StageSeconds seconds;
  std::string renderer, device;
  std::uint64_t rows = 0, rows_rejected = 0;
  int matrices_measured = 0, systems_normal = 0, systems_matrix = 0;
  int nan_depths = 0;
  // The terms of the sums above. Different shares of the work can have terms in common.
  std::vector<PointReport> points;
  std::vector<MatrixRows> matrices;
};

struct InferencePiece;  // host/fields/inference/pipeline/inference_pieces.h

/// Returns the file of a texture, relative to the output folder.
std::string texture_file(const AnimationJob& job, std::size_t object, std::size_t layer, const ParameterPoint& point);

/// Returns whether a sample is held out. Every `hold_out`-th view is held out if the layer has the same texture in
/// other views.
bool is_held_out(const AnimationJob& job, int hold_out, const AnimationLayer& layer, int sample);

/// Infers the textures of some pieces and writes no manifest. Throws the same errors as infer_animation().
AnimationInferResult infer_pieces(const ParameterizedScene& field, const AnimationInferSettings& settings,
                                  const ObjectMappings& mappings, const std::vector<InferencePiece>& pieces,
                                  Progress* progress);

/// Sums up the textures of all pieces, and writes their manifest.
void finish_inference(const ParameterizedScene& field, const AnimationInferSettings& settings,
                      const ObjectMappings& mappings, AnimationInferResult& result);

/// Throws Error or Cancelled. Finished textures remain.
AnimationInferResult infer_animation(const ParameterizedScene& field, const AnimationInferSettings& settings,
                                     Progress* progress);

}  // namespace multum
