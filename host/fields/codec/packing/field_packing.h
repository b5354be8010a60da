// SPDX-License-Identifier: Apache-2.0
// Packs the textures of a parameterized animation, a folder written by `multum infer`, into one file (Hakura et al.
// 2000, section 4). Every layer of every object over every block of the parameters is a chunk. All chunks are coded
// with the same lambda, the error that justifies one bit. A search finds the lambda for the requested file size or
// error.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/fields/codec/chunk_choice.h"
#include "host/fields/codec/packing/field_target.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct FieldPackSettings {
  std::string folder, output;  // the output is named *.mpt
  FieldTarget target;
  /// If alpha is above 1, the mean error per pixel of each object must not exceed this multiple of the mean error over
  /// all objects' pixels (Hakura et al. 2000, section 4). 0 means that there is no limit.
  double alpha = 0.0;
  PyramidChoice pyramid = PyramidChoice::kAdaptive;
  std::optional<ImageCoder> coder;  // if unset, the best of all coders
  bool open_loop = false;
  int block = 8;                          // most samples of a chunk along a parameter
  bool stagger = false;                   // let the blocks of different objects begin at different samples
                                          // (field_blocks.h)
  bool has_absolute_geometry = false;     // store the scene file's absolute path instead of a relative one
  int threads = 0;                        // <= 0 uses all cores; the number does not change the bytes
  std::uint64_t memory_bytes = 0;         // limit of resident memory; 0 means a quarter of the machine's memory
  bool resume = false;                    // continue a stopped packing with the same settings
  ImageTransforms* transforms = nullptr;  // computes coefficients; if null, no device is used
};

struct PackedChunkReport {
  std::string object, layer;
  std::size_t block = 0, bytes = 0;
  double mse = 0.0;  // the object's share of the estimated error
};

struct PackedObjectReport {
  std::string object;
  double pixels = 0.0;  // covered pixels in all samples
  double mse = 0.0;     // estimated error over these pixels
  double lambda = 0.0;  // lambda of the object's chunks
};

struct FieldPackReport {
  std::uint64_t bytes = 0, description_bytes = 0, raw_bytes = 0;  // raw_bytes: size of the 24-bit frames
  double lambda = 0.0, mse = 0.0;
  int rounds = 0;                  // how many times the whole field was coded
  std::size_t chunks_resumed = 0;  // number of chunk codings taken from a stopped packing
  double mse_covered = 0.0;        // error of the pixels that objects cover, to which alpha refers
  bool is_alpha_met = true;
  /// The error of frames drawn with the inferred textures, compared with the ray-traced frames, over all pixels and in
  /// 8-bit sRGB units. Unset if the folder has no report of `multum infer`.
  std::optional<double> inferred_mse;
  // True if coding adds an error above error_limit(inferred_mse) and the user set no error limit.
  bool is_error_large = false;
  bool has_given_way = false;               // the default ratio was lowered
  std::vector<PackedObjectReport> objects;  // only objects with textures
  std::vector<PackedChunkReport> chunks;
};

/// Writes a temporary file and renames it when it is complete. Throws Error(kUsage) for a target that cannot be met,
/// Error(kInput) for a folder that cannot be read, or Error(kEnvironment). Throws Cancelled.
FieldPackReport pack_field(const FieldPackSettings& settings, Progress* progress);

}  // namespace multum
