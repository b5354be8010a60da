// SPDX-License-Identifier: Apache-2.0
// Packs the textures of a parameterised animation, a folder that multum infer wrote, into one file (Hakura et al. 2000,
// section 4): every layer of every object over every block of the parameters is a chunk, all coded for one worth of a
// bit, which is searched for until the file has the size, or the error, that was asked for.
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
  std::string folder, output;  // output *.mpt
  FieldTarget target;
  /// Above 1: no object's mean error a pixel may be more than so many times that of all objects' pixels together
  /// (Hakura et al. 2000, section 4). 0: any.
  double alpha = 0.0;
  PyramidChoice pyramid = PyramidChoice::kAdaptive;
  std::optional<ImageCoder> coder;  // the best of all when not given
  bool open_loop = false;
  int block = 8;                          // samples of a chunk along a parameter, at most
  bool stagger = false;                   // objects' blocks begin at different samples: field_blocks.h
  bool has_absolute_geometry = false;     // the scene file's path is noted whole, not relative to the output's folder
  int threads = 0;                        // <= 0: all; the bytes are the same
  std::uint64_t memory_bytes = 0;         // resident memory to stay within; 0: a quarter of the machine's
  bool resume = false;                    // takes up what a packing of the same that was stopped has done
  ImageTransforms* transforms = nullptr;  // that make coefficients; null: those without a device
};

struct PackedChunkReport {
  std::string object, layer;
  std::size_t block = 0, bytes = 0;
  double mse = 0.0;  // its share of the estimate
};

struct PackedObjectReport {
  std::string object;
  double pixels = 0.0;  // that it covers, of all samples
  double mse = 0.0;     // of these, estimated
  double lambda = 0.0;  // that its chunks were coded with
};

struct FieldPackReport {
  std::uint64_t bytes = 0, description_bytes = 0, raw_bytes = 0;  // raw: of 24-bit frames
  double lambda = 0.0, mse = 0.0;
  int rounds = 0;                  // of coding everything
  std::size_t chunks_resumed = 0;  // how often one was taken from a packing that was stopped
  double mse_covered = 0.0;        // of pixels that objects cover: what alpha is of
  bool is_alpha_met = true;
  /// Of frames drawn of the textures, beside the ray-traced ones: over all pixels, 8-bit sRGB units. None: the folder
  /// has no report of `multum infer`.
  std::optional<double> inferred_mse;
  bool is_error_large = false;              // coding adds more than error_limit() of that, and no error was asked for
  bool has_given_way = false;               // the default ratio has
  std::vector<PackedObjectReport> objects;  // of those with textures
  std::vector<PackedChunkReport> chunks;
};

/// The file appears whole, by rename. Throws Error: kUsage for a target that cannot be met, kInput for a folder that
/// cannot be read, kEnvironment; Cancelled.
FieldPackReport pack_field(const FieldPackSettings& settings, Progress* progress);

}  // namespace multum
