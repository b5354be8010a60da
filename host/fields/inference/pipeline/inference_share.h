// SPDX-License-Identifier: Apache-2.0
// Divides an inference among processes that share the output folder. A share infers the textures of its pieces
// (inference_pieces.h) and writes its results to a record (host/foundation/base/share_record.h). A merge checks the
// records of all shares and the hashes of their textures, and writes the manifest. A single process would write the
// same manifest.
#pragma once

#include "host/fields/inference/pipeline/inference_pipeline.h"

namespace multum {

struct InferenceShare {
  int index = 1, count = 1;  // index from 1
};

struct InferenceShareResult {
  bool was_there = false;  // true if nothing was done, because a complete share with the same inputs and settings
                           // existed
  int textures = 0;        // textures of the share, including existing ones
};

/// Throws Error or Cancelled. Finished textures remain.
InferenceShareResult infer_share(const ParameterizedScene& field, const AnimationInferSettings& settings,
                                 const InferenceShare& share, Progress* progress);

/// Returns the same result as infer_animation(). Throws Error(kEnvironment) if the record or textures of a share are
/// missing, damaged or made from other inputs. The message names every such share and the option that makes it again.
AnimationInferResult merge_inference(const ParameterizedScene& field, const AnimationInferSettings& settings, int count,
                                     Progress* progress);

}  // namespace multum
