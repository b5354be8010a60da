// SPDX-License-Identifier: Apache-2.0
// Divides an inference among processes that share the output folder: a share infers the textures of its pieces
// (inference_pieces.h) and notes what it found in a record (host/foundation/base/share_record.h); a merge checks the
// records of all shares, and their textures by their hashes, and writes the manifest: byte for byte that of one
// process.
#pragma once

#include "host/fields/inference/pipeline/inference_pipeline.h"

namespace multum {

struct InferenceShare {
  int index = 1, count = 1;  // index from 1
};

struct InferenceShareResult {
  bool was_there = false;  // whole, of the same inputs and settings: nothing was done
  int textures = 0;        // of the share, with those that were there
};

/// Throws Error, Cancelled; textures that are finished stay.
InferenceShareResult infer_share(const ParameterizedScene& field, const AnimationInferSettings& settings,
                                 const InferenceShare& share, Progress* progress);

/// As if infer_animation() had done all. Throws Error(kEnvironment) that names every share whose record or textures are
/// missing, damaged or of something else, with the option that makes it again.
AnimationInferResult merge_inference(const ParameterizedScene& field, const AnimationInferSettings& settings, int count,
                                     Progress* progress);

}  // namespace multum
